"""What several commands share: reading specs, telling diagnostics, common options."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import click

from wmspec.diagnostics import WmsError, suggestion

F = TypeVar("F", bound=Callable[..., Any])

specs_argument = click.argument("specs", nargs=-1, required=True, type=click.Path(path_type=Path))
spec_argument = click.argument("spec", type=click.Path(path_type=Path))
seed_option = click.option("--seed", default=0, show_default=True, help="What all draws depend on.")
json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON, for machines.")
dimension_option = click.option(
    "--only-dimension", multiple=True, metavar="PATH", help="Only tasks of this dimension, such as perception.motion."
)
instance_option = click.option("--instance", "-i", default=0, show_default=True, metavar="I", help="Which instance.")


def look_options(command: F) -> F:
    """The options `--look` and `--samples`."""
    look = click.option(
        "--look",
        type=click.Choice(["parity", "beauty"]),
        default="parity",
        show_default=True,
        help="The same picture from every engine, or the best that an engine can draw.",
    )
    samples = click.option("--samples", type=click.IntRange(1, 4096), help="Samples a pixel, for the look beauty.")
    return look(samples(command))


def samples_for(look: str, samples: int | None) -> int | None:
    """The samples, if the look has any. Raises WmsError if not."""
    if look == "parity" and samples is not None:
        raise WmsError("the look `parity` has no samples to choose; leave out --samples, or add --look beauty")
    return samples


def spec_files(paths: Iterable[Path]) -> list[Path]:
    """The spec files meant: a file as it is, a folder as every .wms below it. Raises WmsError where there is none."""
    files: list[Path] = []
    for path in paths:
        if path.is_dir():
            found = sorted(path.rglob("*.wms"))
            if not found:
                raise WmsError(f"{path}: there is no .wms file in this folder")
            files += found
        else:
            files.append(path)
    return list(dict.fromkeys(files))


def load_tasks(paths: Iterable[Path]) -> list[tuple[Path, Any]]:
    """The checked tasks of all spec files, each with its file. Libraries yield none.

    Warnings go to standard error. Raises SpecError with every mistake of every file.
    """
    from wmspec.check.task import check
    from wmspec.diagnostics import Report

    report = Report()
    tasks = [(path, task) for path in spec_files(paths) for task in check(path, report)]
    report.stop_if_failed()
    for diagnostic in report.diagnostics:
        click.echo(diagnostic.render(), err=True)
    if not tasks:
        raise WmsError("there is no task in the files given; a task begins with `task NAME : DIMENSION {`")
    names: dict[str, Path] = {}
    for path, task in tasks:
        if task.name in names:
            raise WmsError(f"two tasks are called `{task.name}`: in {names[task.name]} and in {path}; rename one")
        names[task.name] = path
    return tasks


def of_dimensions(tasks: list[tuple[Path, Any]], dimensions: Sequence[str]) -> list[tuple[Path, Any]]:
    """The tasks of any of the dimensions, or of one below; all without dimensions. Raises WmsError if one has none."""
    known = {task.dimension for _, task in tasks}
    for wanted in dimensions:
        if not any(_within(dimension, wanted) for dimension in known):
            parts = {d.rsplit(".", n)[0] for d in known for n in range(d.count(".") + 1)}
            raise WmsError(f"no task has the dimension `{wanted}`; {suggestion(wanted, parts)}".rstrip("; "))
    return [(p, t) for p, t in tasks if not dimensions or any(_within(t.dimension, d) for d in dimensions)]


def _within(dimension: str, wanted: str) -> bool:
    return f"{dimension}.".startswith(f"{wanted}.")


def executable(tasks: list[tuple[Path, Any]], paths: Iterable[Path]) -> list[tuple[Path, Any]]:
    """The tasks that can be executed. What else a folder holds is told and left out.

    Raises WmsError for a file that was named itself, and where nothing is left.
    """
    from wmspec.stage.agents import refuse

    named, found = set(paths), []
    for path, task in tasks:
        try:
            refuse(task)
            found.append((path, task))
        except WmsError as error:
            if path in named or len(tasks) == 1:
                raise
            click.echo(f"left out `{task.name}`: {error}", err=True)
    if not found:
        raise WmsError("none of these tasks can be executed yet; `wmspec list` shows all that there are")
    return found


def one_task(path: Path) -> Any:
    """The only task of a spec file. Raises WmsError if it has none or several."""
    tasks = load_tasks([path])
    if len(tasks) > 1:
        raise WmsError(f"{path} has {len(tasks)} tasks; this command takes a file with one")
    return tasks[0][1]


def instance_of(design: Any, index: int) -> Any:
    """An instance by index. Raises WmsError outside the design."""
    try:
        return design[index]
    except IndexError as error:
        raise WmsError(f"{error}") from None


def parse_size(text: str) -> tuple[int, int]:
    """`256` or `320x240` as width and height in pixels. Raises WmsError for anything else."""
    match = re.fullmatch(r"(\d+)(?:x(\d+))?", text.strip())
    width, height = (int(match[1]), int(match[2] or match[1])) if match else (0, 0)
    if not (16 <= width <= 4096 and 16 <= height <= 4096):
        raise WmsError(f"size `{text}`: expected pixels such as 256 or 320x240, each from 16 to 4096")
    return width, height


def parse_share(text: str) -> tuple[int, int]:
    """`2/8` as the second of eight shares. Raises WmsError for anything else."""
    match = re.fullmatch(r"(\d+)/(\d+)", text.strip())
    number, count = (int(match[1]), int(match[2])) if match else (0, 0)
    if not 1 <= number <= count:
        raise WmsError(f"shard `{text}`: expected one of so many, from 1/8 for the first of eight to 8/8 for the last")
    return number, count


def make_folder(path: Path) -> Path:
    """Create a folder to write to. Raises WmsError with the reason if that is impossible."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise WmsError(f"{path}: cannot be made a folder: {error.strerror}") from None
    return path


def write_text(path: Path, text: str) -> Path:
    """Write a text file. Raises WmsError with the reason if that is impossible."""
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise WmsError(f"{path}: cannot be written: {error.strerror}") from None
    return path
