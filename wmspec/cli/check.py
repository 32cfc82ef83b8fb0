"""`wmspec check`: are these specs right?"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wmspec.cli.common import balanced, by_size, paint, standard_input, within

if TYPE_CHECKING:
    from wmspec.api import Diagnosis
    from wmspec.compile.design.design import Design


@click.command("check")
@click.argument("specs", nargs=-1, required=True, type=click.Path(path_type=Path, allow_dash=True))
@click.option("--format", "form", type=click.Choice(["text", "json", "sarif"]), default="text", show_default=True)
@click.option("--json", "form", flag_value="json", help="The same as --format json.")
@click.option(
    "--timeout", type=click.FloatRange(1), default=600.0, show_default=True, help="Seconds that all of it may take."
)
def check_command(specs: tuple[Path, ...], form: str, timeout: float) -> None:
    """Check specs: names, units, kinds, the design, and a sample of scenes; `-` checks standard input.

    Exits with 2 if there is a mistake.

    Text is coloured on a terminal, unless NO_COLOR is set. SARIF is what code hosts show beside the lines.
    """
    from wmspec.api import diagnose

    with within(timeout):
        diagnosis = diagnose(*specs) if specs != (Path("-"),) else diagnose(text=standard_input().text)
    if form == "json":
        records = [d.record() for d in diagnosis.diagnostics]
        sizes = {name: design.sample_sizes for name, design in diagnosis.designs.items()}
        told = {"diagnostics": records, "tasks": dict(diagnosis.tasks), "sample_sizes": sizes}
        click.echo(json.dumps(told, indent=2))
    elif form == "sarif":
        from wmspec.cli.sarif import sarif

        click.echo(json.dumps(sarif(diagnosis.diagnostics), indent=2))
    else:
        _print(diagnosis)
    if not diagnosis.passed:
        raise SystemExit(2)


def _print(diagnosis: Diagnosis) -> None:
    """Diagnostics to standard error, the tasks without mistakes to standard output."""
    for diagnostic in diagnosis.diagnostics:
        click.echo(diagnostic.render(paint()) + "\n", err=True)
    for name, count in diagnosis.tasks:
        if name not in diagnosis.mistaken:
            click.echo(f"{name}: {count:,} instances, no mistakes")
            if name in diagnosis.designs:
                _print_design(diagnosis.designs[name])
    if not diagnosis.passed:
        errors = [d for d in diagnosis.diagnostics if d.severity == "error"]
        codes = sorted({d.code for d in errors})
        more = f"`wmspec explain {codes[0]}` tells more"
        click.echo(f"{len(errors)} mistake{'s' * (len(errors) != 1)}; {more}", err=True)
    elif not diagnosis.tasks:
        click.echo("no tasks here, and no mistakes")


def _print_design(design: Design) -> None:
    """The sample sizes, and what balance may cost."""
    for size, names in by_size(design.sample_sizes).items():
        click.echo(f"  {size:,} independent group{'s' * (size != 1)}: {', '.join(names)}")
    if question := design.spec.plan.balance:
        click.echo(f"  {balanced(question)}")
