"""`wmspec generate`: datasets."""

from __future__ import annotations

import json
import os
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from wmspec.cli.common import (
    dimension_option,
    executable,
    json_option,
    load_tasks,
    look_options,
    of_dimensions,
    parse_share,
    parse_size,
    samples_for,
    seed_option,
    specs_argument,
)
from wmspec.cli.cost import tell_cost
from wmspec.cli.progress import progress_bar
from wmspec.diagnostics import WmsError


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
@click.option("--size", default="256", show_default=True, help="Pixels of a picture: 256, or 320x240.")
@look_options
@seed_option
@click.option(
    "--consensus",
    type=click.Choice(["all", "majority", "none"]),
    default="all",
    show_default=True,
    help="Keep a question if all engines agree on it, if most of them do, or whatever they say.",
)
@click.option("--workers", "-j", type=click.IntRange(1, 512), help="Worker processes.  [default: one per core]")
@click.option(
    "--timeout", type=click.FloatRange(1), default=300.0, show_default=True, help="Seconds an instance may take."
)
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
    workers: int | None,
    timeout: float,
    dry_run: bool,
    force: bool,
    as_json: bool,
) -> None:
    """Make a dataset of the tasks in SPECS: Parquet with pictures, a manifest and a card.

    A run that was stopped, or killed, goes on where it was when the same command is given again: every finished
    instance is kept, and only those that were under way (some five for each worker) are made again.

    Many machines: each makes its own share into its own folder, a dataset by itself (-o part-2 --shard 2/8). The same
    command without --shard makes one of them (-o whole --reuse part-1 --reuse part-2 ...), as if there had been one.
    """
    from wmspec import __version__
    from wmspec.design.design import Design
    from wmspec.execute.backends import chosen, drawing, engine_version
    from wmspec.execute.pool import Effort
    from wmspec.write.plan import Plan, Task

    if full and per_task:
        raise WmsError("--full makes all instances and --per-task some of them; give one of the two")
    tasks = executable(of_dimensions(load_tasks(specs), only_dimension), specs)
    part = parse_share(shard)
    engines = chosen(backend) if renderer else drawing(chosen(backend), look)
    drawers = drawing(chosen(renderer), look) if renderer else engines
    if renderer and len(drawers) > 1:
        raise WmsError("one engine draws; name it with --renderer, or leave it out so that each draws for itself")
    plan = Plan(
        texts=_texts(tasks),
        tasks=tuple(Task(spec, indices(Design(spec, seed), per_task, full, part)) for _, spec in tasks),
        engines=engines,
        size=parse_size(size),
        seed=seed,
        consensus=consensus,
        look=look,
        samples=samples_for(look, samples),
        renderer=drawers[0] if renderer else "",
        versions={"wmspec": __version__} | {name: engine_version(name) for name in {*engines, *drawers}},
    )
    for task in plan.tasks:
        if not task.spec.questions:
            raise WmsError(f"the task `{task.spec.name}` has no question, so there is nothing to generate")
    effort = Effort(workers or os.cpu_count() or 1, timeout)
    if dry_run:
        tell_cost(plan, effort, as_json)
    elif output is None:
        raise WmsError("where to? give the folder of the dataset with -o, or --dry-run to learn what it would take")
    else:
        _make(output, plan, effort, reuse, force, as_json)


def _make(output: Path, plan: Any, effort: Any, reuse: tuple[Path, ...], force: bool, as_json: bool) -> None:
    from wmspec.write.dataset import Dataset
    from wmspec.write.generate import generate
    from wmspec.write.reuse import Before

    before = Before(reuse, plan)
    with Dataset.open(output, plan, force) as dataset:
        for notice in dataset.notices:
            click.echo(notice, err=True)
        total = sum(len(shard.indices) for shard in dataset.pending())
        try:
            with progress_bar(total, "generating") as progress:
                generate(dataset, effort, progress, before)
        except KeyboardInterrupt:
            click.echo("\nstopped; give the same command again to go on", err=True)
            raise SystemExit(130) from None
        summary = dataset.finish()
    click.echo(json.dumps(asdict(summary)["tasks"], indent=2) if as_json else summary)


def _texts(tasks: list[tuple[Path, Any]]) -> dict[str, str]:
    """The specs and what they use, by file name, with as much of the path as tells two files apart."""
    from wmspec.diagnostics import Report
    from wmspec.parse.load import load

    texts: dict[str, str] = {}
    paths = sorted({path.resolve() for path, _ in tasks})
    for path in paths:
        parts = next(n for n in range(1, 99) if [p.parts[-n:] for p in paths].count(path.parts[-n:]) == 1)
        program = load(path, Report())
        texts["/".join(path.parts[-parts:])] = program.source.text
        texts |= {file.span.source.name: file.span.source.text for file in program.libraries}
    return texts


def indices(design: Any, per_task: int | None, full: bool, part: tuple[int, int]) -> tuple[int, ...]:
    """The instances to make: all, or a sample as large as asked for or as the paper's, and of these a share."""
    from wmspec.design.design import share
    from wmspec.paper import instances

    count = len(design) if full else per_task or instances(design.spec.name, len(design.spec.questions))
    chosen = range(len(design)) if count is None or count >= len(design) else sorted(design.sample(count))
    return tuple(chosen[share(len(chosen), *part)])
