"""`wmspec generate`: generate a dataset."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from wmspec.cli import INTERRUPTED
from wmspec.cli.common import (
    dimension_option,
    exit_if_failed,
    instance_timeout_option,
    json_option,
    look_options,
    parse_share,
    parse_size,
    seed_option,
    shares_option,
    size_option,
    tell,
)
from wmspec.cli.cost import print_cost
from wmspec.core.diagnostics import WmsError

if TYPE_CHECKING:
    from wmspec.api import DatasetOptions


@click.command("generate")
@click.argument("specs", nargs=-1, type=click.Path(path_type=Path))
@click.option("--output", "-o", type=click.Path(path_type=Path), help="Dataset folder.")
@click.option("--backend", "-b", default="all", show_default=True, help="Engines: comma-separated names, or all.")
@click.option(
    "--rows",
    type=click.Choice(["questions", "engines"]),
    default="questions",
    show_default=True,
    help="One row per question, answered in all engines, or one per question and engine.",
)
@click.option(
    "--renderer",
    "-r",
    default="",
    help="Render with this engine.  [default: the quickest; with --rows engines, each draws its own]",
)
@click.option(
    "--per-task",
    type=click.IntRange(1),
    help="Number of random instances per task; control groups stay whole, so the number may differ.  "
    "[default: the paper's number for its tasks, else all]",
)
@click.option("--shard", metavar="I/N", default="1/1", help="Generate only share I of N of each task's instances.")
@click.option(
    "--reuse",
    multiple=True,
    type=click.Path(path_type=Path),
    help="Folder of an earlier dataset whose instances are reused. Repeatable.",
)
@click.option(
    "--profile",
    type=click.Choice(["wm-abench"]),
    help="The paper's 44 tasks as in the paper: one kind of question each, and the paper's number of pictures.",
)
@click.option(
    "--split",
    type=click.Choice(["train", "validation", "test"]),
    help="Only this split of control groups; train and validation without the hold-outs of the specs.",
)
@shares_option
@click.option("--full", is_flag=True, help="All instances of every task, also beyond WM-ABench's count.")
@dimension_option
@size_option
@click.option(
    "--film",
    type=click.Choice(["8", "12", "16", "24", "30", "60"]),
    metavar="FPS",
    help="Add a lossless film of every option, with 8, 12, 16, 24, 30 or 60 frames per second.",
)
@click.option("--film-size", metavar="WxH", help="Size of films in pixels.  [default: 832x480]")
@click.option(
    "--film-for",
    type=click.FloatRange(0, 60, min_open=True),
    metavar="SECONDS",
    help="Continue films at least this long after the shown part, for models whose clips have a fixed length.",
)
@look_options
@seed_option
@click.option(
    "--consensus",
    type=click.Choice(["all", "majority", "none"]),
    default="all",
    show_default=True,
    help="Keep a question if all engines agree, if the majority agrees, or always.",
)
@click.option(
    "--licence",
    default="",
    help="SPDX identifier of the data licence.  [default: from the specs; CC-BY-4.0 for specs of wmspec]",
)
@click.option("--workers", "-j", type=click.IntRange(1, 512), help="Worker processes.  [default: one per core]")
@instance_timeout_option
@click.option(
    "--executor",
    type=click.Choice(["local", "ray"]),
    default="local",
    show_default=True,
    help="Run in local processes or on a Ray cluster.",
)
@click.option(
    "--address", default="", help="Address of the Ray cluster: auto, or HOST:PORT.  [default: this machine only]"
)
@click.option(
    "--dry-run", is_flag=True, help="Generate a few instances per task and print a cost estimate; write nothing."
)
@click.option("--force", is_flag=True, help="Replace a different dataset in the folder.")
@json_option
def generate_command(
    specs: tuple[Path, ...],
    output: Path | None,
    backend: str,
    rows: Any,
    renderer: str,
    per_task: int | None,
    shard: str,
    reuse: tuple[Path, ...],
    full: bool,
    profile: Any,
    split: str | None,
    shares: str,
    dimension: tuple[str, ...],
    size: str,
    film: str | None,
    film_size: str | None,
    film_for: float | None,
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
    """Generate a dataset from the tasks in SPECS: Parquet with pictures, a manifest and a card.

    With --profile wm-abench, SPECS may be left out.

    Each question is executed in every engine of --backend and must have the same answer there. The first engine is the
    reference: its episode is drawn and shown. The column `agreement` has the answers of all engines.

    An interrupted run resumes with the same command: finished instances are kept, and only those in progress (at
    most two instances, or two sets of matched instances, per worker) are repeated.

    Several machines: each generates its share into its own folder (-o part-2 --shard 2/8). The same command without
    --shard joins them (-o whole --reuse part-1 --reuse part-2 ...). On a Ray cluster, use --executor ray.

    Exits with 1 if no question was kept, or if more than a tenth of the instances ended as internal errors, crashes or
    timeouts; the first cause is printed in full. With --dry-run, only errors count.
    """
    from wmspec.api import generate, progress_bar
    from wmspec.api.agreement import worker_settings
    from wmspec.api.generating import plan_dataset
    from wmspec.lang.parse.files import catalogue_folders

    if not (specs or profile):
        raise click.UsageError("missing argument SPECS, such as specs/perception, or --profile wm-abench")
    specs = specs or catalogue_folders()
    options: DatasetOptions = {
        "per_task": per_task,
        "full": full,
        "profile": profile or "",
        "split": split or "",
        "shares": shares,
        "part": parse_share(shard),
        "dimensions": dimension,
        "backend": backend,
        "rows": rows,
        "renderer": renderer,
        "consensus": consensus,
        "seed": seed,
        "size": parse_size(size),
        "look": look,
        "samples": samples,
        "film": int(film) if film else None,
        "licence": licence,
    }
    if film_size:
        options["film_size"] = parse_size(film_size)
    if film_for is not None:
        options["film_for"] = film_for
    if dry_run:
        plan = plan_dataset(specs, tell, **options)
        print_cost(plan, worker_settings(workers, timeout, plan.engines), as_json)
        return
    if output is None:
        raise WmsError("missing option --output FOLDER, or --dry-run for a cost estimate")
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
            **options,
        )
    except KeyboardInterrupt:
        click.echo("\nstopped; the same command resumes", err=True)
        raise SystemExit(INTERRUPTED) from None
    click.echo(json.dumps(asdict(summary)["tasks"], indent=2) if as_json else summary)
    exit_if_failed(summary.tally)
