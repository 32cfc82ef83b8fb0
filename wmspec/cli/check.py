"""`wmspec check`: check specs."""

from __future__ import annotations

import json
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wmspec.cli.common import balance_note, by_size, paint, read_stdin, tell, time_limit
from wmspec.cli.trial import CountType, print_engines_hint, print_trials
from wmspec.core.diagnostics import WmsError

if TYPE_CHECKING:
    from wmspec.api.checking import Checked, CheckedTask
    from wmspec.api.trying import TriedTask


@click.command("check")
@click.argument("specs", nargs=-1, required=True, type=click.Path(path_type=Path, allow_dash=True))
@click.option(
    "--format",
    "form",
    type=click.Choice(["text", "json", "sarif", "github", "gitlab"]),
    default="text",
    show_default=True,
    help="Format of the output: also SARIF, annotations for GitHub, and code quality reports for GitLab.",
)
@click.option("--json", "form", flag_value="json", help="Same as --format json.")
@click.option(
    "--timeout",
    type=click.FloatRange(1),
    default=600.0,
    show_default=True,
    help="Time limit of the whole check, in seconds.",
)
@click.option("--strict", is_flag=True, help="Refuse asset files with features that would be approximated or ignored.")
@click.option("--no-cache", is_flag=True, help="Ignore cached results and store none.")
@click.option(
    "--try",
    "count",
    type=CountType(1),
    is_flag=False,
    flag_value=4,
    metavar="[N]",
    help="Make N random instances of each task, and apply all gates.  [N: 4]",
)
@click.option(
    "--backend",
    "-b",
    default="",
    metavar="ENGINES",
    help="Engines of --try, with commas, or all.  [default: the first installed]",
)
def check_command(
    specs: tuple[Path, ...],
    form: str,
    timeout: float,
    strict: bool,
    no_cache: bool,
    count: int | None,
    backend: str,
) -> None:
    """Check specs: syntax, names, units, types, the design, and a sample of scenes. `-` reads standard input.

    Exits with 2 if there is an error. With --try it also exits with 2 if a question keeps no instance, or if all
    kept instances have the same answer (at least 8 instances, from at least 4 groups).

    The result of a file is kept in the user's cache (WMSPEC_CACHE_DIR, else ~/.cache/wmspec) and returned again until
    the file, a library or file that it uses, or wmspec changes.

    Text is coloured on a terminal unless NO_COLOR is set. Code hosts display SARIF beside the lines of a spec.
    """
    from wmspec.api.checking import check_files, check_text
    from wmspec.core.disk_cache import disabled

    if count and (form not in ("text", "json") or specs == (Path("-"),)):
        raise WmsError("--try needs spec files, and prints text or JSON")
    if backend and not count:
        raise WmsError("--backend selects the engines of --try", help="add --try")
    with time_limit(timeout), disabled() if no_cache else nullcontext():
        checked = check_text(read_stdin()) if specs == (Path("-"),) else check_files(specs)
        checked = _strict(checked) if strict else checked
        trials = _tried(specs, count, backend) if count and checked.passed and checked.tasks else ()
    if form == "json":
        records = [d.record() for d in checked.diagnostics]
        counts = {task.name: task.instances for task in checked.tasks}
        sizes = {task.name: task.sample_sizes for task in checked.tasks if task.sample_sizes is not None}
        tried = {"trials": [trial.record() for trial in trials]} if count else {}
        click.echo(json.dumps({"diagnostics": records, "tasks": counts, "sample_sizes": sizes, **tried}, indent=2))
    elif form == "sarif":
        from wmspec.cli.sarif import sarif

        click.echo(json.dumps(sarif(checked.diagnostics), indent=2))
    elif form in ("github", "gitlab"):
        from wmspec.cli.annotations import github, gitlab

        shown = github(checked.diagnostics) if form == "github" else json.dumps(gitlab(checked.diagnostics), indent=2)
        click.echo(shown.rstrip("\n"))
    else:
        _print(checked)
        print_trials(trials)
        print_engines_hint(trials)
    if not checked.passed or not all(trial.passed for trial in trials):
        raise SystemExit(2)


def _strict(checked: Checked) -> Checked:
    """Return the result with approximations of asset files as errors."""
    from wmspec.api.loading import without_approximations  # imports the checker, which a cached result does not need

    return replace(checked, diagnostics=without_approximations(checked.diagnostics))


def _tried(specs: tuple[Path, ...], count: int, backend: str) -> tuple[TriedTask, ...]:
    """Try the tasks that have questions."""
    from wmspec.api import load_all
    from wmspec.api.progress import progress_bar
    from wmspec.api.trying import try_tasks

    tasks = [task for task in load_all(*specs, tell=lambda _: None) if task.questions]
    return try_tasks(tasks, count, backend=backend, progress=progress_bar, tell=tell) if tasks else ()


def _print(checked: Checked) -> None:
    """Print diagnostics to standard error, and tasks without mistakes to standard output."""
    for diagnostic in checked.diagnostics:
        click.echo(diagnostic.render(paint()) + "\n", err=True)
    for task in checked.tasks:
        if not task.mistaken:
            click.echo(f"{task.name}: {task.instances:,} instances, no mistakes")
            _print_design(task)
    if not checked.passed:
        errors = [d for d in checked.diagnostics if d.severity == "error"]
        codes = sorted({d.code for d in errors})
        more = f"see `wmspec explain {codes[0]}`"
        click.echo(f"{len(errors)} mistake{'s' * (len(errors) != 1)}; {more}", err=True)
    elif not checked.tasks:
        click.echo("no tasks, no mistakes")


def _print_design(task: CheckedTask) -> None:
    """Print the sample sizes and the cost of balance."""
    for size, names in by_size(task.sample_sizes or {}).items():
        click.echo(f"  {size:,} independent group{'s' * (size != 1)}: the sample size of {', '.join(names)}")
    if task.balance:
        click.echo(f"  {balance_note(task.balance)}")
