"""`wmspec fmt`: format specs."""

from __future__ import annotations

import difflib
import os
import tempfile
from pathlib import Path

import click

from wmspec.cli.common import paint, read_stdin
from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace


@click.command("fmt")
@click.argument("specs", nargs=-1, required=True, type=click.Path(path_type=Path, allow_dash=True))
@click.option("--check", "only_check", is_flag=True, help="Write nothing; exit with 1 if a file would change.")
@click.option("--diff", is_flag=True, help="Write nothing; show what would change.")
def fmt_command(specs: tuple[Path, ...], only_check: bool, diff: bool) -> None:
    """Format specs in place; `-` formats standard input to standard output.

    Changes whitespace, indentation and alignment only.
    """
    from wmspec.core.diagnostics import SpecError
    from wmspec.lang.parse.files import read_source, spec_files
    from wmspec.lang.parse.format import format_spec

    changed = failed = 0
    for path in [Path("-")] if specs == (Path("-"),) else spec_files(specs):
        source = read_stdin() if path == Path("-") else read_source(path)
        try:
            formatted = format_spec(source)
        except SpecError as error:
            click.echo(f"{error.render(paint())}\n", err=True)
            failed += 1
            continue
        changed += formatted != source.text
        if diff:
            click.echo(_difference(source.text, formatted, source.name), nl=False)
        elif only_check and formatted != source.text:
            click.echo(f"{path}: would change", err=True)
        elif path == Path("-") and not only_check:
            click.echo(formatted, nl=False)
        elif not only_check and formatted != source.text:
            _replace(path, formatted)
            click.echo(path)
    if failed:
        raise SystemExit(2)
    if only_check and changed:
        raise SystemExit(1)


def _difference(before: str, after: str, name: str) -> str:
    lines = difflib.unified_diff(before.splitlines(keepends=True), after.splitlines(keepends=True), name, name)
    return "".join(line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n" for line in lines)


def _replace(path: Path, text: str) -> None:
    """Replace the file atomically and keep its permissions; follow a link."""
    path = path.resolve()
    name = ""
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        with os.fdopen(handle, "w", encoding="utf-8", newline="\n") as file:
            file.write(text)
        Path(name).chmod(path.stat().st_mode)
        Path(name).replace(path)
    except OSError as error:
        if name:
            Path(name).unlink(missing_ok=True)
        raise WmsError(f"cannot be written: {error.strerror}", FilePlace(str(path))) from None
