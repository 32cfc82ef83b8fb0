"""`wmspec crosscheck`: do the engines agree?"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from wmspec.cli.common import executable, load_tasks, seed_option, specs_argument, write_text
from wmspec.cli.progress import progress_bar
from wmspec.diagnostics import WmsError

#: The most disagreements that are told in full on the terminal; the files hold all.
MOST_TOLD = 20


@click.command("crosscheck")
@specs_argument
@click.option(
    "--backends",
    "--backend",
    "-b",
    default="all",
    show_default=True,
    help="Two or more engines: names joined by commas, or all.",
)
@click.option(
    "--sample",
    "-n",
    type=click.IntRange(1),
    default=20,
    show_default=True,
    help="How many instances of each task, drawn at random.",
)
@seed_option
@click.option(
    "--tolerance",
    "-t",
    "settings",
    multiple=True,
    metavar="NAME=VALUE",
    help="Another tolerance, such as drift=1cm/s; also rest, impact, event, angle. May be given several times.",
)
@click.option("--strict", is_flag=True, help="Fail also where trajectories part, though the answers agree.")
@click.option("--json", "json_file", metavar="FILE", help="Write everything as JSON; - for standard output.")
@click.option("--junit", "junit_file", metavar="FILE", help="Write JUnit XML, a test case per instance.")
@click.option("--workers", "-j", type=click.IntRange(1, 512), help="Worker processes.  [default: one per core]")
@click.option(
    "--timeout", type=click.FloatRange(1), default=300.0, show_default=True, help="Seconds an instance may take."
)
def crosscheck_command(
    specs: tuple[Path, ...],
    backends: str,
    sample: int,
    seed: int,
    settings: tuple[str, ...],
    strict: bool,
    json_file: str | None,
    junit_file: str | None,
    workers: int | None,
    timeout: float,
) -> None:
    """Execute the same instances in several engines and compare trajectories, events and answers; draws nothing.

    Exits with 1 if a question that either engine would be asked has another answer in the other, or if an engine cannot
    execute an instance. With --strict, and for tasks without questions, trajectories must be within tolerance too.
    """
    from wmspec.check.record import to_json
    from wmspec.compare.record import junit, record
    from wmspec.compare.sweep import Job, sweep
    from wmspec.compare.tolerance import tolerances
    from wmspec.execute.backends import chosen
    from wmspec.execute.pool import Effort

    engines = chosen(backends)
    if len(engines) < 2:
        raise WmsError(f"a crosscheck needs two engines, and there is only {engines[0]}; try `wmspec doctor`")
    tasks = [spec for _, spec in executable(load_tasks(specs), specs)]
    limits = tuple((t.name, tolerances(settings, t.tolerances)) for t in tasks)
    job = Job(tuple((t.name, to_json(t)) for t in tasks), seed, engines, limits)
    try:
        with progress_bar(sum(_count(t, seed, sample) for t in tasks), "crosschecking") as progress:
            checked = sweep(tasks, sample, job, Effort(workers or os.cpu_count() or 1, timeout), progress)
    except KeyboardInterrupt:
        raise SystemExit(130) from None
    if junit_file:
        write_text(Path(junit_file), junit(job, checked, strict))
    if json_file:
        text = json.dumps(record(job, checked, strict), indent=2, ensure_ascii=False)
        if json_file == "-":
            click.echo(text)
        else:
            write_text(Path(json_file), text + "\n")
    if json_file != "-":
        _print(checked, engines, strict)
    if not all(c.passes(strict) for c in checked):
        raise SystemExit(1)


def _count(task: Any, seed: int, sample: int) -> int:
    from wmspec.design.design import Design

    return min(sample, len(Design(task, seed)))


def _print(checked: Sequence[Any], engines: Sequence[str], strict: bool) -> None:
    from rich.console import Console
    from rich.table import Table

    from wmspec.compare.say import complaints
    from wmspec.compare.summary import lines, suspects
    from wmspec.compare.sweep import pairs

    table = Table(box=None, pad_edge=False, header_style="bold")
    headings = ("task", "engines", "answers", "before gates", "within tolerance", "gap, median", "largest", "event")
    for heading in headings:
        table.add_column(heading, justify="left" if heading in headings[:2] else "right", overflow="fold")
    for line in lines(checked, pairs(engines)):
        table.add_row(
            line.task,
            " ".join(line.engines),
            *(str(share) for share in (line.answers, line.before_gates, line.episodes)),
            f"{line.median * 100:.2f} cm",
            f"{line.largest * 100:.2f} cm",
            f"{line.late * 1000:.1f} ms",
        )
    Console(width=None if os.isatty(1) else 120).print(table)
    failed = [c for c in checked if not c.passes(strict)]
    for instance in failed[:MOST_TOLD]:
        settings = ", ".join(f"{k} {_short(v)}" for k, v in instance.factors.items())
        click.echo(f"\n{instance.task}, instance {instance.index} ({settings})")
        for complaint in complaints(instance, strict):
            click.echo(f"  {complaint}")
    if len(failed) > MOST_TOLD:
        click.echo(f"\n... and {len(failed) - MOST_TOLD} more instances; --json FILE has them all")
    found = suspects(checked)
    if found:
        click.echo("\nmore often with:")
    for s in found:
        where = f"where {s.factor} is {_short(s.value)}"
        click.echo(f"  {s.task}: {s.what} in {s.with_it} instances {where}, in {s.without} elsewhere")
    click.echo(f"\n{len(checked) - len(failed)} of {len(checked)} instances pass")


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
