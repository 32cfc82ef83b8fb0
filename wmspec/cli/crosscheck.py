"""`wmspec crosscheck`: compare engines."""

from __future__ import annotations

import math
import os
import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from wmspec.cli.common import exit_if_failed, instance_timeout_option, seed_option, specs_argument, tell, write_text
from wmspec.cli.crosscheck_outputs import write_outputs
from wmspec.core.diagnostics import WmsError

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
@click.option("--changed-since", metavar="REF", default="", help="Only tasks whose files changed since a git revision.")
@click.option("--baseline", "baseline_file", metavar="FILE", help="Known disagreements, which do not fail.")
@click.option("--update-baseline", is_flag=True, help="Write the current disagreements to the baseline.")
@click.option(
    "--fail-under",
    type=click.FloatRange(0, 100),
    default=100.0,
    show_default=True,
    metavar="PERCENT",
    help="Fail if fewer instances pass.",
)
@click.option(
    "--max-time", default="", metavar="TIME", help="Begin no instance after this time, such as 5m. Tasks alternate."
)
@click.option(
    "--cache", "cache_folder", metavar="DIR", help="Folder of results of earlier runs.  [default: the user's cache]"
)
@click.option("--no-cache", is_flag=True, help="Execute all instances, and store no results.")
@click.option("--json", "json_file", metavar="FILE", help="Write all results as JSON; - for standard output.")
@click.option("--junit", "junit_file", metavar="FILE", help="Write JUnit XML with a test case per instance.")
@click.option("--sarif", "sarif_file", metavar="FILE", help="Write SARIF with the question of each new disagreement.")
@click.option("--gitlab", "gitlab_file", metavar="FILE", help="Write a GitLab code quality report.")
@click.option("--html", "html_file", metavar="FILE", help="Write a page with pictures and paths of new disagreements.")
@click.option(
    "--annotations",
    type=click.Choice(["auto", "github", "none"]),
    default="auto",
    show_default=True,
    help="Print annotations for GitHub; auto does if GITHUB_ACTIONS is true.",
)
@click.option("--workers", "-j", type=click.IntRange(1, 512), help="Worker processes.  [default: one per core]")
@instance_timeout_option
def crosscheck_command(
    specs: tuple[Path, ...],
    backends: str,
    sample: int,
    seed: int,
    settings: tuple[str, ...],
    strict: bool,
    changed_since: str,
    baseline_file: str | None,
    update_baseline: bool,
    fail_under: float,
    max_time: str,
    cache_folder: str | None,
    no_cache: bool,
    workers: int | None,
    timeout: float,
    **outputs: str | None,
) -> None:
    """Execute the same instances in several engines and compare trajectories, events and answers.

    Exits with 1 if engines answer a question differently that one of them would keep, or if an engine cannot execute
    an instance. With --strict, and for tasks without questions, trajectories must be within tolerance too.
    Also exits with 1 if no instance was compared; the first internal error is printed in full.

    An instance that was executed before, by the same versions of wmspec and of the engines, is not executed again.
    Only --html draws pictures.
    """
    from wmspec.api import crosscheck, progress_bar

    if update_baseline and not baseline_file:
        raise WmsError("--update-baseline needs a file", help="add --baseline FILE")
    agreement = crosscheck(
        specs,
        sample=sample,
        backend=backends,
        seed=seed,
        tolerance=settings,
        strict=strict,
        changed_since=changed_since,
        baseline=None if update_baseline and not Path(str(baseline_file)).exists() else baseline_file,
        fail_under=fail_under,
        max_time=parse_time(max_time) if max_time else None,
        cache=False if no_cache else cache_folder or True,
        workers=workers,
        timeout=timeout,
        progress=progress_bar,
        tell=tell,
    )
    if update_baseline:
        agreement = _update(agreement, Path(str(baseline_file)))
    write_outputs(agreement, outputs)
    if outputs["json_file"] != "-":
        _print(agreement, changed_since)
    if agreement.planned:
        exit_if_failed(agreement.tally)
    if not agreement.passed:
        raise SystemExit(1)


def parse_time(text: str) -> float:
    """Parse a time such as 5m, 90s or 1h, in seconds. Raises WmsError otherwise."""
    match = re.fullmatch(r"(\d+(?:\.\d+)?)\s*(s|m|min|h)?", text.strip())
    seconds = float(match[1]) * {"m": 60.0, "min": 60.0, "h": 3600.0}.get(match[2], 1.0) if match else 0.0
    if not 0 < seconds < math.inf:
        raise WmsError(f"--max-time {text}: expected a time such as 5m, 90s or 1h")
    return seconds


def _update(agreement: Agreement, path: Path) -> Agreement:
    """Write the baseline and return the agreement with it."""
    before, after = agreement.baseline, agreement.updated_baseline
    write_text(path, after.text())
    added, removed = len(after.identities - before.identities), len(before.identities - after.identities)
    tell(f"{path}: {len(after.known)} known disagreements, {added} added, {removed} removed")
    return replace(agreement, baseline=after)


def _print(agreement: Agreement, changed_since: str) -> None:
    if changed_since and not agreement.tasks:
        click.echo(f"no task has changed since {changed_since}")
        return
    _print_table(agreement)
    _print_failures(agreement)
    if agreement.suspects:
        click.echo("\nmore often with:")
    for s in agreement.suspects:
        where = f"where {s.factor} is {_short(s.value)}"
        click.echo(f"  {s.task}: {s.what} in {s.with_it} instances {where}, in {s.without} elsewhere")
    if agreement.unreliable_answers:
        click.echo("\nanswers that depend on motion that engines simulate wrongly:")
    for d in agreement.unreliable_answers:
        click.echo(f"  {d.task}: {d.answers}, because {d.kind}; in instance {d.instance}, {d.where}")
    if agreement.vanished:
        click.echo("\nno longer found; --update-baseline removes them from the baseline:")
    for gone in agreement.vanished:
        click.echo(f"  {gone.task}, instance {gone.index}: {gone.reason}")
    _print_counts(agreement)


def _print_failures(agreement: Agreement) -> None:
    failed = agreement.failed
    for instance in failed[:MAX_PRINTED]:
        settings = ", ".join(f"{k} {_short(v)}" for k, v in instance.factors.items())
        click.echo(f"\n{instance.task}, instance {instance.index} ({settings})")
        for complaint in agreement.complaints(instance):
            click.echo(f"  {complaint}")
    if len(failed) > MAX_PRINTED:
        click.echo(f"\n... and {len(failed) - MAX_PRINTED} more instances; --json FILE writes all")


def _print_table(agreement: Agreement) -> None:
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


def _print_counts(agreement: Agreement) -> None:
    count, failed = len(agreement.instances), len(agreement.failed)
    known = sum(not c.passes(agreement.strict) for c in agreement.instances) - failed
    accepted = f", {known} of them with known disagreements" if known else ""
    click.echo(f"\n{count - failed} of {count} instances pass{accepted}")
    if agreement.fail_under < 100:
        click.echo(f"{agreement.share:.4g} % pass; at least {agreement.fail_under:g} % must")
    if count < agreement.planned:
        click.echo(f"{agreement.planned - count} of {agreement.planned} instances did not begin in time")
    if agreement.cached:
        click.echo(f"{agreement.cached} of {count} results are from the cache")
    if agreement.refused:
        tell(
            f"warning: {agreement.refused} cache entries are ignored: damaged, another user's, or writable by others; "
            "`chmod -R go-w DIR` if they are yours"
        )


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
