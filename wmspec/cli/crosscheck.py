"""`wmspec crosscheck`: compare engines."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from wmspec.cli.common import exit_if_failed, seed_option, specs_argument, tell, write_text

if TYPE_CHECKING:
    from wmspec.api import Agreement

#: The most disagreements printed in full; the files contain all.
MAX_PRINTED = 20


@click.command("crosscheck")
@specs_argument
@click.option(
    "--backends",
    "--backend",
    "-b",
    default="all",
    show_default=True,
    help="Two or more engines: comma-separated names, or all.",
)
@click.option(
    "--sample",
    "-n",
    type=click.IntRange(1),
    default=20,
    show_default=True,
    help="Number of random instances per task.",
)
@seed_option
@click.option(
    "--tolerance",
    "-t",
    "settings",
    multiple=True,
    metavar="NAME=VALUE",
    help="Override a tolerance, such as drift=1cm/s; also rest, impact, event, angle. Repeatable.",
)
@click.option("--strict", is_flag=True, help="Also fail if trajectories diverge although answers agree.")
@click.option("--json", "json_file", metavar="FILE", help="Write all results as JSON; - for standard output.")
@click.option("--junit", "junit_file", metavar="FILE", help="Write JUnit XML with a test case per instance.")
@click.option("--workers", "-j", type=click.IntRange(1, 512), help="Worker processes.  [default: one per core]")
@click.option(
    "--timeout", type=click.FloatRange(1), default=300.0, show_default=True, help="Time limit per instance, in seconds."
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
    """Execute the same instances in several engines and compare trajectories, events and answers. Draws no pictures.

    Exits with 1 if a question that either engine would be asked has another answer in the other, or if an engine cannot
    execute an instance. With --strict, and for tasks without questions, trajectories must be within tolerance too.
    Also exits with 1 if no instance was compared; the first internal error is printed in full.
    """
    from wmspec.api import crosscheck, progress_bar

    agreement = crosscheck(
        specs,
        sample=sample,
        backend=backends,
        seed=seed,
        tolerance=settings,
        strict=strict,
        workers=workers,
        timeout=timeout,
        progress=progress_bar,
        tell=tell,
    )
    if junit_file:
        write_text(Path(junit_file), agreement.junit())
    if json_file:
        text = json.dumps(agreement.record(), indent=2, ensure_ascii=False)
        if json_file == "-":
            click.echo(text)
        else:
            write_text(Path(json_file), text + "\n")
    if json_file != "-":
        _print(agreement)
    exit_if_failed(agreement.tally)
    if not agreement.passed:
        raise SystemExit(1)


def _print(agreement: Agreement) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    headings = ("task", "engines", "answers", "before gates", "within tolerance", "gap, median", "largest", "event")
    for heading in headings:
        table.add_column(heading, justify="left" if heading in headings[:2] else "right", overflow="fold")
    for line in agreement.lines:
        table.add_row(
            line.task,
            " ".join(line.engines),
            *(str(share) for share in (line.answers, line.before_gates, line.episodes)),
            f"{line.median * 100:.2f} cm",
            f"{line.largest * 100:.2f} cm",
            f"{line.late * 1000:.1f} ms",
        )
    Console(width=None if os.isatty(1) else 120).print(table)
    failed = agreement.failed
    for instance in failed[:MAX_PRINTED]:
        settings = ", ".join(f"{k} {_short(v)}" for k, v in instance.factors.items())
        click.echo(f"\n{instance.task}, instance {instance.index} ({settings})")
        for complaint in agreement.complaints(instance):
            click.echo(f"  {complaint}")
    if len(failed) > MAX_PRINTED:
        click.echo(f"\n... and {len(failed) - MAX_PRINTED} more instances; --json FILE writes all")
    if agreement.suspects:
        click.echo("\nmore often with:")
    for s in agreement.suspects:
        where = f"where {s.factor} is {_short(s.value)}"
        click.echo(f"  {s.task}: {s.what} in {s.with_it} instances {where}, in {s.without} elsewhere")
    if agreement.unreliable_answers:
        click.echo("\nanswers that depend on motion that engines simulate wrongly:")
    for d in agreement.unreliable_answers:
        click.echo(f"  {d.task}: {d.answers}, as {d.kind}; in instance {d.instance}, {d.where}")
    click.echo(f"\n{len(agreement.instances) - len(failed)} of {len(agreement.instances)} instances pass")


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
