"""`wmspec recast`: people's own photographs and clips as a dataset."""

from __future__ import annotations

from pathlib import Path

import click


@click.command("recast")
@click.argument("table", type=click.Path(path_type=Path))
@click.option(
    "--images", type=click.Path(path_type=Path), required=True, help="The folder with the pictures and clips."
)
@click.option("--output", "-o", type=click.Path(path_type=Path), required=True, help="The folder of the dataset.")
@click.option(
    "--size",
    type=click.IntRange(64, 4096),
    default=768,
    show_default=True,
    help="The longest side of a picture, in pixels; larger ones are made smaller.",
)
def recast_command(table: Path, images: Path, output: Path, size: int) -> None:
    """Make a dataset of your own photographs and clips.

    TABLE is a CSV with a question a row: question, pictures, options, answer, and more if you like (docs/recast.md).
    What comes out is read by evaluate, report, audit and view like any other dataset. The pictures lose their metadata.
    """
    from wmspec.eval.image_import.recast import recast

    made = recast(table, images, output, size)
    for task, count in made.questions.items():
        click.echo(f"{task}: {count:,} {'question' if count == 1 else 'questions'}")
    if made.unlicensed:
        click.echo(
            f"{made.unlicensed:,} rows state no licence (column `license`): say under which the pictures are", err=True
        )
    if made.unused:
        more = f" and {len(made.unused) - 3:,} more" if len(made.unused) > 3 else ""
        click.echo(f"not asked about: {', '.join(made.unused[:3])}{more}", err=True)
    click.echo(output)
