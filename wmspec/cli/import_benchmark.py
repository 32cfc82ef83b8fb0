"""`wmspec import`: create a dataset from a released benchmark."""

from __future__ import annotations

from pathlib import Path

import click

from wmspec.cli.common import image_size_option
from wmspec.core.diagnostics import WmsError


@click.command("import")
@click.argument("form", metavar="FORMAT", type=click.Choice(["wm-abench"]))
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--output", "-o", type=click.Path(path_type=Path), required=True, help="Dataset folder.")
@click.option(
    "--dimension",
    "dimensions",
    multiple=True,
    metavar="TASK=PATH",
    help="Dimension of a task, such as perception.space.",
)
@click.option("--limit", type=click.IntRange(1), metavar="N", help="Maximum number of questions of a task.")
@image_size_option
def import_benchmark_command(
    form: str, folder: Path, output: Path, dimensions: tuple[str, ...], limit: int | None, size: int
) -> None:
    """Create a dataset from a released benchmark, so that evaluate, report and audit work on it.

    FORMAT is wm-abench: FOLDER holds its Parquet files, with the columns source, prompt, choices_str_letter,
    image_choices and answer. A task is a folder of files, or a file.
    """
    from wmspec.eval.image_import.importer import import_wm_abench

    assert form == "wm-abench"
    named = dict(each.partition("=")[::2] for each in dimensions)
    for task, dimension in named.items():
        if not dimension:
            raise WmsError(f"--dimension {task}: expected TASK=PATH, such as relation_tdw=perception.space")
    result = import_wm_abench(folder, output, size, named, limit)
    for task, count in result.questions.items():
        click.echo(f"{task}: {count:,} {'question' if count == 1 else 'questions'}")
    click.echo(output)
