"""`wmspec view`: a dataset as a picture for people."""

from __future__ import annotations

from pathlib import Path

import click

from wmspec.errors import WmsError


@click.command("view")
@click.argument("dataset", type=click.Path(path_type=Path))
@click.option(
    "--output", "-o", type=click.Path(path_type=Path), required=True, help="The picture to write, a .png file."
)
@click.option(
    "--per-task", type=click.IntRange(1, 50), default=3, show_default=True, help="How many instances of each task."
)
def view_command(dataset: Path, output: Path, per_task: int) -> None:
    """Draw a contact sheet of a dataset: frames, options and answer, engine beside engine."""
    from wmspec.write.sheet import contact_sheet

    if output.suffix.lower() != ".png":
        raise WmsError(f"{output}: a contact sheet is written as a .png file")
    picture = contact_sheet(dataset, per_task)
    try:
        picture.save(output)
    except OSError as error:
        raise WmsError(f"{output}: cannot be written: {error.strerror or error}") from None
    click.echo(output)
