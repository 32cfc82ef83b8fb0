"""`wmspec import-images`: create a dataset from photographs and clips."""

from __future__ import annotations

from pathlib import Path

import click

from wmspec.cli.common import image_size_option


@click.command("import-images")
@click.argument("table", type=click.Path(path_type=Path))
@click.option("--images", type=click.Path(path_type=Path), required=True, help="Folder of the pictures and clips.")
@click.option("--output", "-o", type=click.Path(path_type=Path), required=True, help="Dataset folder.")
@image_size_option
def import_images_command(table: Path, images: Path, output: Path, size: int) -> None:
    """Create a dataset from your own photographs and clips.

    TABLE is a CSV with one question per row: question, pictures, options, answer, and optional columns
    (docs/recast.md). The result works with evaluate, report, audit and view. Picture metadata is removed.
    """
    from wmspec.eval.image_import.importer import import_images

    result = import_images(table, images, output, size)
    for task, count in result.questions.items():
        click.echo(f"{task}: {count:,} {'question' if count == 1 else 'questions'}")
    if result.unlicensed:
        click.echo(f"{result.unlicensed:,} rows have no licence; give one in the column `license`", err=True)
    if result.unused:
        more = f" and {len(result.unused) - 3:,} more" if len(result.unused) > 3 else ""
        click.echo(f"pictures without a question: {', '.join(result.unused[:3])}{more}", err=True)
    click.echo(output)
