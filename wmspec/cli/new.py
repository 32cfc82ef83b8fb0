"""`wmspec new`: a first spec, to begin with."""

from __future__ import annotations

from pathlib import Path

import click

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace


def _list(context: click.Context, _: click.Parameter, wanted: bool) -> None:
    if not wanted:
        return
    from wmspec.editor.start import about

    for name, what in about().items():
        click.echo(f"{name:12} {what}")
    context.exit()


@click.command("new")
@click.argument("name")
@click.option("--template", "-t", default="prediction", show_default=True, help="What it is made from; see --list.")
@click.option("--list", is_flag=True, is_eager=True, expose_value=False, callback=_list, help="List the templates.")
def new_command(name: str, template: str) -> None:
    """Write a first spec to NAME.wms, which checks and generates as it is. NAME may have a folder before it.

    A file that is there is never overwritten.
    """
    from wmspec.editor.start import SUFFIX, first_spec

    path = Path(name).with_suffix(SUFFIX) if name.endswith(SUFFIX) else Path(f"{name}{SUFFIX}")
    text = first_spec(path.stem, template)
    try:
        with path.open("x", encoding="utf-8", newline="\n") as file:
            file.write(text)
    except FileExistsError:
        raise WmsError("is there already", FilePlace(str(path)), "choose another name, or remove it first") from None
    except OSError as error:
        raise WmsError(f"cannot be written: {error.strerror}", FilePlace(str(path))) from None
    click.echo(f"{path}: try `wmspec watch {path}`, then `wmspec generate {path} -o out --per-task 6`")
