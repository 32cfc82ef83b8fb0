"""`wmspec view`: show a dataset as a page, a folder or a contact sheet."""

from __future__ import annotations

from pathlib import Path

import click

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import writing

#: The default number of instances per task, by suffix of the output.
DEFAULT_PER_TASK = {".png": 3, ".html": 20, "": 50}


@click.command("view")
@click.argument("dataset", type=click.Path(path_type=Path))
@click.option(
    "--output",
    "-o",
    type=click.Path(path_type=Path),
    default=Path("gallery.html"),
    show_default=True,
    help="A page (.html), a folder with page and pictures, or a contact sheet (.png).",
)
@click.option(
    "--per-task",
    type=click.IntRange(1),
    help="Instances per task.  [default: 20 in a page, 50 in a folder, 3 on a sheet]",
)
@click.option(
    "--results",
    multiple=True,
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Results of models and people (evaluate, study collect) to show next to the truth.",
)
def view_command(dataset: Path, output: Path, per_task: int | None, results: tuple[Path, ...]) -> None:
    """Show a dataset as a page: frames, options and answers, engines side by side.

    The page opens from disk in any browser. Answers are hidden until you answer or reveal them.
    """
    kind = output.suffix.lower()
    if kind not in DEFAULT_PER_TASK:
        raise WmsError(
            "unknown output format: expected .html for a page, .png for a sheet, or a folder", FilePlace(str(output))
        )
    count = per_task or DEFAULT_PER_TASK[kind]
    if kind == ".png":
        from wmspec.dataset.build.sheet import contact_sheet

        picture = contact_sheet(dataset, count)
        with writing(output):
            picture.save(output)
        click.echo(output)
        return
    from wmspec.dataset.build.reader import DatasetReader
    from wmspec.eval.gallery.gallery import folder, page
    from wmspec.eval.gallery.records import read

    opened = DatasetReader.open(dataset)
    shown = (page if kind == ".html" else folder)(opened, count, output, read(results))
    where = output if kind == ".html" else output / "index.html"
    some = any(task["instances"] > count for task in opened.manifest["tasks"].values())
    which = f" of {count} instances of each task (--per-task)" if some else ""
    click.echo(f"{where}: {shown:,} questions{which}; open it in a browser")
