"""`wmspec doctor`: test the installation and print remedies."""

from __future__ import annotations

import json
from dataclasses import asdict

import click

from wmspec.cli.common import json_option


@click.command("doctor")
@click.option("--capabilities", is_flag=True, help="Print the capability matrix of the engines instead.")
@json_option
@click.pass_context
def doctor_command(ctx: click.Context, capabilities: bool, as_json: bool) -> None:
    """Test the installation and print remedies.

    A command is given where the cause is known; any other failure is shown, with how to report it.

    Each engine executes and draws a falling cube. Exit code 0 if at least one engine does both, else 1.
    """
    from wmspec.runtime.doctor.doctor import examine, fit

    if capabilities:
        _capabilities(as_json)
        return
    findings = examine()
    if as_json:
        click.echo(json.dumps({"ok": fit(findings), "findings": [asdict(f) for f in findings]}, indent=2))
    else:
        width = max(len(f.name) for f in findings)
        for finding in findings:
            mark = click.style("ok", fg="green") if finding.ok else click.style("--", fg="red")
            click.echo(f"{mark}  {finding.name:{width}}  {finding.found}")
        for finding in findings:
            if finding.report:
                click.echo(f"\n{finding.name} failed for an unknown reason: {finding.found}\n{finding.report}")
        for cure in dict.fromkeys(f.remedy for f in findings if f.remedy):
            click.echo(f"\nto fix {', '.join(f.name for f in findings if f.remedy == cure)}:\n  {cure}")
    ctx.exit(0 if fit(findings) else 1)


def _capabilities(as_json: bool) -> None:
    from wmspec.runtime.engines.registry import info, names
    from wmspec.sim.scene.capability import APPROXIMATE, capability_table

    engines = [info(name) for name in names()]

    def _mark(why: str) -> str:
        if why.startswith(APPROXIMATE):
            return click.style("~~", fg="yellow")
        return click.style("--", fg="red") if why else click.style("ok", fg="green")

    rows = capability_table({engine.name: engine.lacks for engine in engines})
    if as_json:
        nearly = [{e: why for e, why in row.items() if why.startswith(APPROXIMATE)} for _, row in rows]
        records = [
            {
                "capability": name,
                "lacking": {e: why for e, why in _lacking(row).items() if e not in near},
                "nearly": {e: why.removeprefix(APPROXIMATE) for e, why in near.items()},
            }
            for (name, row), near in zip(rows, nearly, strict=True)
        ]
        click.echo(json.dumps(records, indent=2))
        return
    for name, row in rows:
        marks = "  ".join(map(_mark, row.values()))
        click.echo(f"{marks}  {name}")
        for reason in dict.fromkeys(_lacking(row).values()):
            click.echo(f"            {reason}")
    click.echo(f"\nin columns: {', '.join(engine.title for engine in engines)}")


def _lacking(row: dict[str, str]) -> dict[str, str]:
    return {engine: reason for engine, reason in row.items() if reason}
