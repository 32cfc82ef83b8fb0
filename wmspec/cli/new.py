"""`wmspec new`: write a first spec."""

from __future__ import annotations

from pathlib import Path

import click

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace


def _list(context: click.Context, _: click.Parameter, requested: bool) -> None:
    if not requested:
        return
    from wmspec.editor.start import template_titles

    for name, what in template_titles().items():
        click.echo(f"{name:12} {what}")
    context.exit()


@click.command("new")
@click.argument("name")
@click.option("--template", "-t", default="prediction", show_default=True, help="Template; see --list.")
@click.option("--list", is_flag=True, is_eager=True, expose_value=False, callback=_list, help="List the templates.")
def new_command(name: str, template: str) -> None:
    """Write a first spec to NAME.wms; `check` and `generate` accept it as it is. NAME may have a folder before it.

    An existing file is never overwritten.
    """
    from wmspec.editor.start import SUFFIX, first_spec

    path = Path(name).with_suffix(SUFFIX) if name.endswith(SUFFIX) else Path(f"{name}{SUFFIX}")
    text = first_spec(path.stem, template)
    try:
        with path.open("x", encoding="utf-8", newline="\n") as file:
            file.write(text)
    except FileExistsError:
        raise WmsError("already exists", FilePlace(str(path)), "choose another name, or remove the file") from None
    except OSError as error:
        raise WmsError(f"cannot be written: {error.strerror}", FilePlace(str(path))) from None
    click.echo(f"{path}: try `wmspec watch {path}`, then `wmspec generate {path} -o out --per-task 6`")
