"""`wmspec check`: are these specs right?"""

from __future__ import annotations

import json
from pathlib import Path

import click

from wmspec.cli.common import json_option, spec_files, specs_argument


@click.command("check")
@specs_argument
@json_option
def check_command(specs: tuple[Path, ...], as_json: bool) -> None:
    """Check specs: names, units, kinds, the design, and a sample of scenes. Exits with 2 if there is a mistake."""
    from wmspec.check.task import check
    from wmspec.parse.diagnostics import Report
    from wmspec.stage.trial import trial

    report = Report()
    tasks = []
    for path in spec_files(specs):
        for spec in check(path, report):
            tasks += [(spec.name, trial(spec, report))]
    found = report.diagnostics
    if as_json:
        click.echo(json.dumps({"diagnostics": [d.record() for d in found], "tasks": dict(tasks)}, indent=2))
    else:
        for diagnostic in found:
            click.echo(diagnostic.render() + "\n", err=True)
        if not report.failed:
            for name, count in tasks:
                click.echo(f"{name}: {count:,} instances, no mistakes")
            if not tasks:
                click.echo("no tasks here, and no mistakes")
        else:
            errors = sum(d.severity == "error" for d in found)
            click.echo(f"{errors} mistake{'s' * (errors != 1)}", err=True)
    if report.failed:
        raise SystemExit(2)
