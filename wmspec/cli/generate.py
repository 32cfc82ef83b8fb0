"""`wmspec generate`: datasets."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from wmspec.cli import INTERRUPTED
from wmspec.cli.common import (
    dimension_option,
    json_option,
    look_options,
    parse_share,
    parse_size,
    seed_option,
    settle,
    size_option,
    specs_argument,
    tell,
)
from wmspec.cli.cost import tell_cost
from wmspec.core.diagnostics import WmsError

if TYPE_CHECKING:
    from wmspec.api import Choices


@click.command("generate")
@specs_argument
@click.option("--output", "-o", type=click.Path(path_type=Path), help="The folder of the dataset.")
@click.option("--backend", "-b", default="all", show_default=True, help="Engines: names joined by commas, or all.")
@click.option("--renderer", "-r", default="", help="The engine that draws, if not each what it executes itself.")
@click.option(
    "--per-task",
    type=click.IntRange(1),
    help="How many instances of each task, drawn at random.  [default: as many as the paper has of its tasks, "
    "all of others]",
)
@click.option("--shard", metavar="I/N", default="1/1", help="Only share I, from 1 to N, of each task's instances.")
@click.option(
    "--reuse",
    multiple=True,
    type=click.Path(path_type=Path),
    help="A folder to take instances from that were made before; may be given several times.",
)
@click.option("--full", is_flag=True, help="All instances of every task, where there are more than the paper's.")
@dimension_option
@size_option
@look_options
@seed_option
@click.option(
    "--consensus",
    type=click.Choice(["all", "majority", "none"]),
    default="all",
    show_default=True,
    help="Keep a question if all engines agree on it, if most of them do, or whatever they say.",
)
@click.option(
    "--licence",
    default="",
    help="The licence of the data, by its SPDX identifier.  [default: what the specs say; CC-BY-4.0 of wmspec's own]",
)
@click.option("--workers", "-j", type=click.IntRange(1, 512), help="Worker processes.  [default: one per core]")
@click.option(
    "--timeout", type=click.FloatRange(1), default=300.0, show_default=True, help="Seconds an instance may take."
)
@click.option(
    "--executor",
    type=click.Choice(["local", "ray"]),
    default="local",
    show_default=True,
    help="Who works: processes of this machine, or those of a Ray cluster.",
)
@click.option("--address", default="", help="Where the Ray cluster is: auto, or HOST:PORT.  [default: only here]")
@click.option(
    "--dry-run", is_flag=True, help="Write nothing: make a few instances of each task and tell what all would take."
)
@click.option("--force", is_flag=True, help="Replace a different dataset in the folder.")
@json_option
def generate_command(
    specs: tuple[Path, ...],
    output: Path | None,
    backend: str,
    renderer: str,
    per_task: int | None,
    shard: str,
    reuse: tuple[Path, ...],
    full: bool,
    only_dimension: tuple[str, ...],
    size: str,
    look: Any,
    samples: int | None,
    seed: int,
    consensus: Any,
    licence: str,
    workers: int | None,
    timeout: float,
    executor: Any,
    address: str,
    dry_run: bool,
    force: bool,
    as_json: bool,
) -> None:
    """Make a dataset of the tasks in SPECS: Parquet with pictures, a manifest and a card.

    A run that was stopped, or killed, goes on where it was when the same command is given again: every finished
    instance is kept, and only those that were under way (some five for each worker) are made again.

    Many machines: each makes its own share into its own folder, a dataset by itself (-o part-2 --shard 2/8). The same
    command without --shard makes one of them (-o whole --reuse part-1 --reuse part-2 ...), as if there had been one.
    Where they form a Ray cluster, --executor ray does all of it, and writes here.

    Exit code 1 if no question was kept, or if more than a tenth of the instances ended as internal errors, crashes or
    timeouts; the first cause is printed in full. With --dry-run, the latter alone counts.
    """
    from wmspec.api import generate, progress_bar
    from wmspec.api.agreement import effort
    from wmspec.api.making import planned

    choices: Choices = {
        "per_task": per_task,
        "full": full,
        "part": parse_share(shard),
        "dimensions": only_dimension,
        "backend": backend,
        "renderer": renderer,
        "consensus": consensus,
        "seed": seed,
        "size": parse_size(size),
        "look": look,
        "samples": samples,
        "licence": licence,
    }
    if dry_run:
        plan = planned(specs, tell, **choices)
        tell_cost(plan, effort(workers, timeout, plan.engines), as_json)
        return
    if output is None:
        raise WmsError("where to? give the folder of the dataset with -o, or --dry-run to learn what it would take")
    try:
        summary = generate(
            specs,
            output,
            reuse=reuse,
            force=force,
            workers=workers,
            timeout=timeout,
            executor=executor,
            address=address,
            progress=progress_bar,
            tell=tell,
            **choices,
        )
    except KeyboardInterrupt:
        click.echo("\nstopped; give the same command again to go on", err=True)
        raise SystemExit(INTERRUPTED) from None
    click.echo(json.dumps(asdict(summary)["tasks"], indent=2) if as_json else summary)
    settle(summary.tally)
