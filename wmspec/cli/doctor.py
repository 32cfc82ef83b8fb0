"""`wmspec doctor`: what works here, and how to mend what does not."""

from __future__ import annotations

import click

from wmspec.cli.common import json_option


@click.command("doctor")
@json_option
@click.pass_context
def doctor_command(ctx: click.Context, as_json: bool) -> None:
    """Say what works on this machine, and the command that mends what does not.

    Each engine executes and draws a falling cube. Exit code 0 if at least one engine does both, else 1.
    """
    import json
    from dataclasses import asdict

    from wmspec.execute.doctor import examine, fit

    findings = examine()
    if as_json:
        click.echo(json.dumps({"ok": fit(findings), "findings": [asdict(f) for f in findings]}, indent=2))
    else:
        width = max(len(f.name) for f in findings)
        for finding in findings:
            mark = click.style("ok", fg="green") if finding.ok else click.style("--", fg="red")
            click.echo(f"{mark}  {finding.name:{width}}  {finding.found}")
        for cure in dict.fromkeys(f.remedy for f in findings if f.remedy):
            click.echo(f"\nto mend {', '.join(f.name for f in findings if f.remedy == cure)}:\n  {cure}")
    ctx.exit(0 if fit(findings) else 1)
