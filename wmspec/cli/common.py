"""What several commands share: their options, and how a person's texts become values."""

from __future__ import annotations

import os
import re
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, TypeVar

import click

from wmspec.core.diagnostics import Paint, Part, WmsError, plain, suggestion
from wmspec.core.places import FilePlace, Source
from wmspec.core.safe_io import make_folders

if TYPE_CHECKING:
    from wmspec.api import Instance
    from wmspec.core.tally import Tally

_COLORS: dict[Part, str] = {"error": "red", "warning": "yellow", "note": "cyan", "help": "green", "caret": "red"}

F = TypeVar("F", bound=Callable[..., Any])

specs_argument = click.argument("specs", nargs=-1, required=True, type=click.Path(path_type=Path))
spec_argument = click.argument("spec", type=click.Path(path_type=Path))
seed_option = click.option("--seed", default=0, show_default=True, help="What all draws depend on.")
json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON, for machines.")
dimension_option = click.option(
    "--only-dimension", multiple=True, metavar="PATH", help="Only tasks of this dimension, such as perception.motion."
)
task_option = click.option("--task", default="", metavar="NAME", help="Which task, of a file that has several.")
instance_option = click.option("--instance", "-i", default=0, show_default=True, metavar="I", help="Which instance.")
size_option = click.option("--size", default="384", show_default=True, help="Pixels of a picture: 384, or 320x240.")
redrawn_option = click.option(
    "--redrawn", default=0, metavar="N", type=click.IntRange(0), help="With its nuisances drawn anew, for the Nth time."
)


def by_size(sizes: Mapping[str, int]) -> dict[int, list[str]]:
    """The names of factors and nuisances, by the sample size that they have in common."""
    named: dict[int, list[str]] = {}
    for name, size in sizes.items():
        named.setdefault(size, []).append(name)
    return named


def balanced(question: str) -> str:
    """What balance may cost."""
    from wmspec.core.limits import MOST_DRAWS

    most = f"each group is drawn up to {MOST_DRAWS} times"
    return f"balanced answers of `{question}`: {most}; `wmspec generate --dry-run` measures how often"


def paint() -> Paint:
    """How diagnostics are coloured."""
    if not _in_colour():
        return plain
    return lambda text, part: click.style(text, fg=_COLORS[part], bold=part != "caret")


def _in_colour() -> bool:
    """On a terminal, unless the user asked for none (https://no-color.org)."""
    return sys.stderr.isatty() and not os.environ.get("NO_COLOR")


def standard_input() -> Source:
    """The text that is piped in, as `-` asks for. Raises WmsError if it is no text."""
    try:
        return Source("<stdin>", sys.stdin.buffer.read().decode("utf-8").replace("\r\n", "\n"))
    except UnicodeDecodeError as error:
        raise WmsError(f"<stdin>: not UTF-8 text (byte {error.start}); a .wms file is plain UTF-8 text") from None


def look_options(command: F) -> F:
    """The options `--look` and `--samples`."""
    look = click.option(
        "--look",
        type=click.Choice(["parity", "photo"]),
        default="parity",
        show_default=True,
        help="The same picture from every engine, or a path-traced one by Mitsuba, for people.",
    )
    samples = click.option("--samples", type=click.IntRange(1, 4096), help="Samples a pixel, for the look photo.")
    return look(samples(command))


class _TimeIsUp(BaseException):
    """No mistake of the user's, which what reads files of others might take it for."""


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """Stop what takes longer. Raises WmsError then, as soon as Python has its turn."""

    def stop(number: int, frame: FrameType | None) -> None:  # noqa: ARG001  a handler is called with both
        raise _TimeIsUp

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    except _TimeIsUp:
        raise WmsError(
            f"it takes longer than {seconds:g} s; check fewer specs, or give it more with --timeout"
        ) from None
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def tell(text: str) -> None:
    """What is doubtful, and what is left out, on standard error."""
    click.echo(text, err=True)


def settle(tally: Tally) -> None:
    """Say on standard error what failed of a run. Exits with 1 if nothing was made, or too much of it failed."""
    if tally.told:
        tell(tally.told)
    if not tally.passed:
        raise SystemExit(1)


def instance_of(path: Path, name: str, index: int, seed: int, redrawn: int = 0) -> Instance:
    """An instance of the task of this name, or of the only one, of a spec file. Raises WmsError if there is none."""
    from wmspec.api import load_all

    tasks = load_all(path, seed=seed, tell=tell)
    names = [task.name for task in tasks]
    if not name and len(tasks) > 1:
        raise WmsError(f"{path} has {len(tasks)} tasks", help=f"choose one with --task: {', '.join(names)}")
    if name and name not in names:
        raise WmsError(f"{path} has no task `{name}`", help=suggestion(name, names) or f"it has {', '.join(names)}")
    task = tasks[names.index(name) if name else 0]
    if index < 0:
        raise WmsError(f"instance {index}: the first is 0")
    try:
        return task[index].redrawn(redrawn)
    except IndexError as error:
        raise WmsError(f"{error}") from None


def parse_size(text: str) -> tuple[int, int]:
    """`384` or `320x240` as width and height in pixels. Raises WmsError for anything else."""
    from wmspec.api.drawing import LEAST_SIDE, MOST_SIDE

    match = re.fullmatch(r"(\d+)(?:x(\d+))?", text.strip())
    width, height = (int(match[1]), int(match[2] or match[1])) if match else (0, 0)
    if not all(LEAST_SIDE <= side <= MOST_SIDE for side in (width, height)):
        limits = f"from {LEAST_SIDE} to {MOST_SIDE}"
        raise WmsError(f"size `{text}`: expected pixels such as 384 or 320x240, each {limits}")
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
        make_folders(path)
    except OSError as error:
        raise WmsError(f"cannot be made a folder: {error.strerror}", FilePlace(str(path))) from None
    return path


def write_text(path: Path, text: str) -> Path:
    """Write a text file. Raises WmsError with the reason if that is impossible."""
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise WmsError(f"cannot be written: {error.strerror}", FilePlace(str(path))) from None
    return path
