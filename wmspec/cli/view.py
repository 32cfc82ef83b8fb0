"""`wmspec view`: a dataset for people, as a page to look at and to answer, or as a picture."""

from __future__ import annotations

from pathlib import Path

import click

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace

#: How many instances of each task are shown on a sheet, in a page and in a folder, if nothing is said.
PER_TASK = {".png": 3, ".html": 20, "": 50}


@click.command("view")
@click.argument("dataset", type=click.Path(path_type=Path))
@click.option(
    "--output",
    "-o",
    type=click.Path(path_type=Path),
    default=Path("gallery.html"),
    show_default=True,
    help="A page (.html), a folder with a page and its pictures, or a contact sheet (.png).",
)
@click.option(
    "--per-task",
    type=click.IntRange(1),
    help="How many instances of each task.  [default: 20 in a page, 50 in a folder, 3 on a sheet]",
)
@click.option(
    "--results",
    multiple=True,
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="What models and people answered (evaluate, study collect), shown beside the truth.",
)
def view_command(dataset: Path, output: Path, per_task: int | None, results: tuple[Path, ...]) -> None:
    """Show a dataset: frames, options and answers, engine beside engine.

    The page opens from the disk in any browser. Truths are hidden until you answer or ask for them.
    """
    kind = output.suffix.lower()
    if kind not in PER_TASK:
        raise WmsError(
            "what to write? a page is a .html file, a sheet a .png file, a folder has no suffix", FilePlace(str(output))
        )
    count = per_task or PER_TASK[kind]
    if kind == ".png":
        _sheet(dataset, output, count)
        click.echo(output)
        return
    from wmspec.dataset.build.reader import DatasetReader
    from wmspec.eval.gallery.gallery import folder, page
    from wmspec.eval.gallery.replies import read

    opened = DatasetReader.open(dataset)
    shown = (page if kind == ".html" else folder)(opened, count, output, read(results))
    where = output if kind == ".html" else output / "index.html"
    some = any(task["instances"] > count for task in opened.manifest["tasks"].values())
    which = f" of {count} instances of each task (--per-task)" if some else ""
    click.echo(f"{where}: {shown:,} questions{which}; open it in a browser")


def _sheet(dataset: Path, output: Path, per_task: int) -> None:
    from wmspec.dataset.build.sheet import contact_sheet

    picture = contact_sheet(dataset, per_task)
    try:
        picture.save(output)
    except OSError as error:
        raise WmsError(f"cannot be written: {error.strerror or error}", FilePlace(str(output))) from None
