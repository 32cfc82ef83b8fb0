"""`wmspec explain`: explain a diagnostic code."""

from __future__ import annotations

import click

from wmspec.core.diagnostics import WmsError


@click.command("explain")
@click.argument("code", required=False)
def explain_command(code: str | None) -> None:
    """Explain a diagnostic's CODE, such as WMS203, with an example. Without CODE: list all."""
    from wmspec.lang.parse.codes import CODES
    from wmspec.lang.parse.pages import page

    if code is None:
        for known, meaning in CODES.items():
            click.echo(f"{click.style(known, bold=True)}  {meaning}")
        return
    requested = code.upper() if code.upper().startswith("WMS") else f"WMS{code}"
    if requested not in CODES:
        alike = [known for known in CODES if known[:4] == requested[:4]]
        hint = f"there are {', '.join(alike)}; " if alike else ""
        raise WmsError(f"there is no code `{code}`", help=f"{hint}`wmspec explain` lists all, with what they mean")
    _show(page(requested).markdown)


def _show(markdown: str) -> None:
    """Print Markdown; headings are bold and examples indented."""
    fenced = False
    for line in markdown.splitlines():
        if line.startswith("```"):
            fenced = not fenced
        elif line.startswith("#"):
            click.secho(line.lstrip("# "), bold=True, underline=line.startswith("# "))
        else:
            click.echo(f"    {line}".rstrip() if fenced else line)
