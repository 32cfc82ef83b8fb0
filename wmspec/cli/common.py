"""Options shared by commands, and parsing of their values."""

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

from wmspec.core.diagnostics import Paint, Part, WmsError, suggestion, unpainted
from wmspec.core.places import FilePlace, Source
from wmspec.core.safe_io import make_folders, writing

if TYPE_CHECKING:
    from wmspec.api import Instance
    from wmspec.core.tally import Tally

_COLORS: dict[Part, str] = {"error": "red", "warning": "yellow", "note": "cyan", "help": "green", "caret": "red"}

F = TypeVar("F", bound=Callable[..., Any])

specs_argument = click.argument("specs", nargs=-1, required=True, type=click.Path(path_type=Path))
spec_argument = click.argument("spec", type=click.Path(path_type=Path))
seed_option = click.option("--seed", default=0, show_default=True, help="Random seed.")
json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON.")
dimension_option = click.option(
    "--dimension", multiple=True, metavar="PATH", help="Only tasks of this dimension, such as perception.motion."
)
size_option = click.option("--size", default="384", show_default=True, help="Picture size in pixels: 384, or 320x240.")

limit_option = click.option(
    "--limit",
    type=click.IntRange(1),
    metavar="N",
    help="Maximum number of questions, spread evenly over tasks and engines.",
)
image_size_option = click.option(
    "--size",
    type=click.IntRange(64, 4096),
    default=768,
    show_default=True,
    help="Longest side of a picture, in pixels; larger pictures are downscaled.",
)
shares_option = click.option(
    "--shares", default="", metavar="SHARES", help="Splits in percent.  [default: train=80,validation=10,test=10]"
)
instance_timeout_option = click.option(
    "--timeout", type=click.FloatRange(1), default=300.0, show_default=True, help="Time limit per instance, in seconds."
)


def by_size(sizes: Mapping[str, int]) -> dict[int, list[str]]:
    """Group the names of factors and nuisances by sample size."""
    named: dict[int, list[str]] = {}
    for name, size in sizes.items():
        named.setdefault(size, []).append(name)
    return named


def balance_note(question: str) -> str:
    """Return a note on the cost of balanced answers."""
    from wmspec.core.limits import MAX_DRAWS

    most = f"each group is drawn up to {MAX_DRAWS} times"
    return f"balanced answers of `{question}`: {most}; `wmspec generate --dry-run` measures how often"


def paint() -> Paint:
    """Return the colouring of diagnostics."""
    if not _has_colour():
        return unpainted
    return lambda text, part: click.style(text, fg=_COLORS[part], bold=part != "caret")


def _has_colour() -> bool:
    """Whether to use colours: on a terminal, unless NO_COLOR is set (https://no-color.org)."""
    return sys.stderr.isatty() and not os.environ.get("NO_COLOR")


def read_stdin() -> Source:
    """Return the text on standard input. Raises WmsError if it is not UTF-8."""
    try:
        return Source("<stdin>", sys.stdin.buffer.read().decode("utf-8").replace("\r\n", "\n"))
    except UnicodeDecodeError as error:
        raise WmsError(f"<stdin>: not UTF-8 text (byte {error.start}); a .wms file is plain UTF-8 text") from None


def instance_options(command: F) -> F:
    """Add the options that choose an instance: `--task`, `--instance`, `--redraw` and `--seed`."""
    task = click.option("--task", default="", metavar="NAME", help="Task, if the file has several.")
    instance = click.option(
        "--instance", "-i", default=0, show_default=True, metavar="I", help="Index of the instance."
    )
    redraw = click.option(
        "--redraw", default=0, metavar="N", type=click.IntRange(0), help="Use the N-th re-sample of the nuisances."
    )
    return task(instance(redraw(seed_option(command))))


def look_options(command: F) -> F:
    """Add the options `--look` and `--samples`."""
    look = click.option(
        "--look",
        type=click.Choice(["parity", "photo"]),
        default="parity",
        show_default=True,
        help="`parity` is equal in all engines; `photo` is path-traced by Mitsuba.",
    )
    samples = click.option("--samples", type=click.IntRange(1, 4096), help="Samples per pixel, with --look photo.")
    return look(samples(command))


class _Timeout(BaseException):
    """A BaseException, so that no handler of other errors catches it."""


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raise WmsError when the block exceeds the time limit, at the next Python instruction."""

    def stop(number: int, frame: FrameType | None) -> None:  # noqa: ARG001  the signature of a handler
        raise _Timeout

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    except _Timeout:
        raise WmsError(f"time limit of {seconds:g} s exceeded; check fewer specs, or set --timeout") from None
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def split_options(command: F) -> F:
    """Add `--shares` and `--holdout` for splits by control groups."""
    holdout = click.option(
        "--holdout",
        "holdouts",
        multiple=True,
        metavar="LEVELS",
        help="Levels that training never sees together, such as shape=cone,color=blue. Repeatable.",
    )
    return shares_option(holdout(command))


def tell(text: str) -> None:
    """Print a warning to standard error."""
    click.echo(text, err=True)


def exit_if_failed(tally: Tally) -> None:
    """Print the failures of a run to standard error; exit with 1 if nothing was made or too much failed."""
    if tally.message:
        tell(tally.message)
    if not tally.passed:
        raise SystemExit(1)


def load_instance(path: Path, name: str, index: int, seed: int, redraw: int = 0, *, strict: bool = False) -> Instance:
    """Return an instance of a spec's task with this name, or of its only task. Raises WmsError if there is none."""
    from wmspec.api import load_all

    tasks = load_all(path, seed=seed, tell=tell, strict=strict)
    names = [task.name for task in tasks]
    if not name and len(tasks) > 1:
        raise WmsError(f"{path} has {len(tasks)} tasks", help=f"choose one with --task: {', '.join(names)}")
    if name and name not in names:
        raise WmsError(f"{path} has no task `{name}`", help=suggestion(name, names) or f"it has {', '.join(names)}")
    task = tasks[names.index(name) if name else 0]
    if index < 0:
        raise WmsError(f"instance {index}: the first is 0")
    try:
        return task[index].redrawn(redraw)
    except IndexError as error:
        raise WmsError(f"{error}") from None


def parse_size(text: str) -> tuple[int, int]:
    """Parse `384` or `320x240` to width and height in pixels. Raises WmsError otherwise."""
    from wmspec.api.rendering import MAX_SIDE, MIN_SIDE

    match = re.fullmatch(r"(\d+)(?:x(\d+))?", text.strip())
    width, height = (int(match[1]), int(match[2] or match[1])) if match else (0, 0)
    if not all(MIN_SIDE <= side <= MAX_SIDE for side in (width, height)):
        limits = f"from {MIN_SIDE} to {MAX_SIDE}"
        raise WmsError(f"size `{text}`: expected pixels such as 384 or 320x240, each {limits}")
    return width, height


def parse_share(text: str) -> tuple[int, int]:
    """Parse `2/8` to (2, 8). Raises WmsError otherwise."""
    match = re.fullmatch(r"(\d+)/(\d+)", text.strip())
    number, count = (int(match[1]), int(match[2])) if match else (0, 0)
    if not 1 <= number <= count:
        raise WmsError(f"shard `{text}`: expected I/N, such as 1/8 for the first of eight shares")
    return number, count


def make_folder(path: Path) -> Path:
    """Create a folder to write to. Raises WmsError with the reason if that is impossible."""
    try:
        make_folders(path)
    except OSError as error:
        raise WmsError(f"cannot create the folder: {error.strerror}", FilePlace(str(path))) from None
    return path


def write_text(path: Path, text: str) -> Path:
    """Write a text file. Raises WmsError with the reason if that is impossible."""
    with writing(path):
        path.write_text(text, encoding="utf-8")
    return path
