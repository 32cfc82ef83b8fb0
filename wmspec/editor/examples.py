"""A few instances of a spec that is being written, in small pictures: drawn in a process of its own."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from wmspec.core.diagnostics import WmsError

if TYPE_CHECKING:
    from wmspec.api.task import Instance, Task
    from wmspec.runtime.questions.model import QuestionRow


@dataclass(frozen=True)
class Cell:
    """A picture (PNG) or a text with a caption; `true` is the option that is right."""

    caption: str
    text: str = ""
    png: bytes = b""
    true: bool = False


@dataclass(frozen=True)
class Asked:
    """A question with what is shown before it and its options; or why it cannot be asked."""

    text: str
    shown: tuple[Cell, ...] = ()
    options: tuple[Cell, ...] = ()
    rejected: str = ""


@dataclass(frozen=True)
class Row:
    """An instance: the values of its factors in words, and what is asked of it."""

    task: str
    index: int
    factors: str
    asked: tuple[Asked, ...]


def draw(text: str, path: Path, task: str, index: int, engine: str, size: int) -> Row:
    """An instance of a spec without mistakes, executed and asked about in an engine, its pictures `size` px wide.

    What cannot be executed, asked or drawn is told in its row.
    """
    instance = _tasks(text, path)[task][index]
    try:
        asked = tuple(_asked(instance, engine, size))
    except WmsError as error:
        asked = (Asked("", rejected=str(error)),)
    return Row(task, index, str(instance), asked)


def picture(text: str, path: Path, task: str, index: int, engine: str, size: int) -> bytes:
    """A sheet (PNG) of what the cameras of an instance observe. Raises WmsError if it cannot be executed or drawn."""
    out = io.BytesIO()
    _tasks(text, path)[task][index].run(engine).sheet(size=size).save(out, "PNG")
    return out.getvalue()


@lru_cache(maxsize=2)
def _tasks(text: str, path: Path) -> dict[str, Task]:
    """The tasks of a text by name. The libraries that it uses may change while this process lives: see `changed`."""
    from wmspec.api.loading import diagnose_text

    return {task.name: task for task in diagnose_text(text, path, tried=False)[1]}


def changed() -> None:
    """Forget texts: a library has changed."""
    _tasks.cache_clear()


def _asked(instance: Instance, engine: str, size: int) -> Iterator[Asked]:
    if not instance.task.questions:
        run = instance.run(engine)
        views = run.views()
        yield Asked("", tuple(Cell(_when(c, t), png=_png(run.frame(c, t, size=size))) for c, t in views))
        return
    answers = instance.ask(engine, size=size)
    for row in answers:
        yield _question(row)
    for refusal in answers.rejected:
        yield Asked("", rejected=f"no question: {refusal.detail or refusal.reason} ({refusal.reason})")


def _question(row: QuestionRow) -> Asked:
    shown = tuple(Cell(_when(p.camera, p.time), png=_png(p.rgb)) for p in row.context)
    options = [
        Cell(o.name if o.picture else "", o.text or "", _png(o.picture.rgb) if o.picture else b"", i == row.answer)
        for i, o in enumerate(row.options)
    ]
    return Asked(row.text, shown, tuple(options) or (Cell("measured", row.value, true=True),))


def _when(camera: str, time: float) -> str:
    return f"{camera}, {time:.3g} s"


def _png(rgb: NDArray[np.uint8]) -> bytes:
    out = io.BytesIO()
    Image.fromarray(rgb).save(out, "PNG", compress_level=3)
    return out.getvalue()
