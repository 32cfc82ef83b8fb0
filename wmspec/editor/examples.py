"""Previews of a few instances of a spec, drawn in a separate process."""

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
    """A captioned picture (PNG) or text; `true` marks the correct option."""

    caption: str
    text: str = ""
    png: bytes = b""
    true: bool = False


@dataclass(frozen=True)
class QuestionPreview:
    """A question with its context and options, or the reason for its rejection."""

    text: str
    context: tuple[Cell, ...] = ()
    options: tuple[Cell, ...] = ()
    rejected: str = ""


@dataclass(frozen=True)
class Row:
    """An instance: its factor levels in words, and its questions."""

    task: str
    index: int
    factors: str
    questions: tuple[QuestionPreview, ...]


def draw(text: str, path: Path, task: str, index: int, engine: str, size: int) -> Row:
    """Return the preview of an instance, executed in an engine, with pictures `size` pixels wide.

    The spec must have no mistakes. Failures are part of the row.
    """
    instance = _tasks(text, path)[task][index]
    try:
        questions = tuple(_questions(instance, engine, size))
    except WmsError as error:
        questions = (QuestionPreview("", rejected=str(error)),)
    return Row(task, index, str(instance), questions)


def picture(text: str, path: Path, task: str, index: int, engine: str, size: int) -> bytes:
    """Return a sheet (PNG) of the observed views of an instance. Raises WmsError if it cannot be executed or drawn."""
    out = io.BytesIO()
    _tasks(text, path)[task][index].run(engine).sheet(size=size).save(out, "PNG")
    return out.getvalue()


@lru_cache(maxsize=2)
def _tasks(text: str, path: Path) -> dict[str, Task]:
    """Return the tasks of a text by name, cached; call `changed` when a library changes."""
    from wmspec.api.loading import TextCheck

    return {task.name: task for task in TextCheck(text, path).tasks}


def changed() -> None:
    """Clear the cache after a change of a library."""
    _tasks.cache_clear()


def _questions(instance: Instance, engine: str, size: int) -> Iterator[QuestionPreview]:
    if not instance.task.questions:
        run = instance.run(engine)
        views = run.views()
        yield QuestionPreview("", tuple(Cell(_when(c, t), png=_png(run.frame(c, t, size=size))) for c, t in views))
        return
    answers = instance.ask(engine, size=size)
    for row in answers:
        yield _question(row)
    for refusal in answers.rejected:
        yield QuestionPreview("", rejected=f"no question: {refusal.detail or refusal.reason} ({refusal.reason})")


def _question(row: QuestionRow) -> QuestionPreview:
    context = tuple(Cell(_when(p.camera, p.time), png=_png(p.rgb)) for p in row.context)
    options = [
        Cell(o.name if o.picture else "", o.text or "", _png(o.picture.rgb) if o.picture else b"", i == row.answer)
        for i, o in enumerate(row.options)
    ]
    return QuestionPreview(row.text, context, tuple(options) or (Cell("measured", row.value, true=True),))


def _when(camera: str, time: float) -> str:
    return f"{camera}, {time:.3g} s"


def _png(rgb: NDArray[np.uint8]) -> bytes:
    out = io.BytesIO()
    Image.fromarray(rgb).save(out, "PNG", compress_level=3)
    return out.getvalue()
