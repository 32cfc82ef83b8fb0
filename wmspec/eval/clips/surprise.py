"""Latent models: how much each future surprises a model that has seen the context.

Of a closed set all contexts and all futures are combined. The raw answer is the future that surprises least. The
centred answer subtracts from every surprise the mean over all contexts, so that a future that is easy to foresee
whatever came before, such as one in which all is at rest, has no advantage.
"""

from __future__ import annotations

import csv
import importlib
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import read_bytes
from wmspec.dataset.build.films import read_frames
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.film.codec import Frames
from wmspec.dataset.film.distances import Array
from wmspec.eval.clips import results as clip_results
from wmspec.eval.clips.questions import FilmQuestion, selected
from wmspec.eval.clips.run import ClipResult, Progress, results_about
from wmspec.eval.models import results
from wmspec.eval.models.question import Selection

Row = dict[str, Any]

#: Prefixes of latent models and of tables of surprises among models.
FUNCTION, TABLE = "surprise:", "surprises:"
#: How answers are read from surprises: the values of the column `prompt`.
RAW, CENTRED = "raw", "centred"


class Surprises(Protocol):
    """A source of surprises."""

    def of(self, question: FilmQuestion, others: dict[int, FilmQuestion]) -> Array:
        """Return the surprises (contexts, futures) of a closed set, in the order of its options; NaN if unknown.

        `others` are the questions of the set by the option that is true.
        """


class FunctionSurprises:
    """Surprises of a Python function `f(context, future, fps, text)`.

    `context` and `future` are uint8 (T, h, w, 3); the result is a number, or one for each frame of the future, of which
    the mean counts. A class is instantiated once, and its object is called.
    """

    def __init__(self, name: str, dataset: DatasetReader) -> None:
        self._function, self._dataset = _function(name), dataset
        self._known: dict[tuple[str, ...], Array] = {}

    def of(self, question: FilmQuestion, others: dict[int, FilmQuestion]) -> Array:
        """Return the surprises of a closed set; each is computed once."""
        if question.films not in self._known:
            films = [read_frames(self._dataset.folder, path) for path in question.films]
            texts = [others.get(option, question).text for option in range(len(films))]
            self._known = {question.films: self._matrix(films, texts, question)}
        return self._known[question.films]

    def _matrix(self, films: list[Frames], texts: list[str], question: FilmQuestion) -> Array:
        split = question.context
        rows = [
            [self._one(shown[:split], film[split:], question.rate, text) for film in films]
            for shown, text in zip(films, texts, strict=True)
        ]
        return np.array(rows)

    def _one(self, context: Frames, future: Frames, rate: int, text: str) -> float:
        value = np.asarray(self._function(context.copy(), future.copy(), rate, text), float)
        if value.ndim > 1 or (value.ndim == 1 and len(value) != len(future)):
            raise WmsError(
                f"the model returned {value.shape} numbers", help=f"return one, or one for each of {len(future)} frames"
            )
        return float(value.mean())


class TableSurprises:
    """Surprises in a CSV file with the columns `id`, `place`, `frame` (may be empty) and `surprise`."""

    def __init__(self, path: Path) -> None:
        self._values = _read_table(path)

    def of(self, question: FilmQuestion, others: dict[int, FilmQuestion]) -> Array:
        """Return the surprises in the table."""
        count = len(question.films)
        matrix = np.full((count, count), np.nan)
        for option, other in others.items():
            for place in range(count):
                matrix[option, place] = self._values.get((other.id, place), math.nan)
        return matrix


def _function(name: str) -> Callable[..., Any]:
    module, colon, attribute = name.partition(":")
    if not colon or not module or not attribute:
        raise WmsError(f"--model surprise:{name}: expected surprise:PACKAGE:FUNCTION")
    try:
        found = getattr(importlib.import_module(module), attribute)
    except (ImportError, AttributeError) as error:
        raise WmsError(f"--model surprise:{name}: {error}", help="install the package, or set PYTHONPATH") from None
    made = found() if isinstance(found, type) else found
    if not callable(made):
        raise WmsError(f"--model surprise:{name}: `{attribute}` is no function")
    return made  # type: ignore[no-any-return]


def _read_table(path: Path) -> dict[tuple[str, int], float]:
    """Return the mean surprise by question and place. Raises WmsError for a file that is no such table."""
    try:
        lines = list(csv.DictReader(read_bytes(path).decode("utf-8").splitlines()))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise WmsError(f"cannot be read: {error}", FilePlace(str(path))) from None
    values: dict[tuple[str, int], list[float]] = {}
    for number, line in enumerate(lines, 2):
        try:
            values.setdefault((line["id"], int(line["place"])), []).append(float(line["surprise"]))
        except (KeyError, TypeError, ValueError):
            message = "expected the columns id, place, frame and surprise, with numbers in `place` and `surprise`"
            raise WmsError(message, FilePlace(str(path), number)) from None
    return {key: float(np.mean(each)) for key, each in values.items()}


# ---------------------------------------------------------------- answers


def choice(surprises: Array) -> int | None:
    """Return the place of the least surprise; None for a tie or unknown values."""
    if np.isnan(surprises).any():
        return None
    least = np.flatnonzero(surprises == surprises.min())
    return int(least[0]) if len(least) == 1 else None


def centred(matrix: Array) -> Array:
    """Return surprises (contexts, futures) without their mean over the contexts."""
    return np.asarray(matrix - matrix.mean(axis=0, keepdims=True))


@dataclass(frozen=True)
class SurpriseRun:
    """A latent model by name, and the questions it answers."""

    dataset: DatasetReader
    name: str
    selection: Selection

    def surprises(self) -> Surprises:
        """Open the model. Raises WmsError if there is none."""
        if self.name.startswith(TABLE):
            return TableSurprises(Path(self.name.removeprefix(TABLE)))
        return FunctionSurprises(self.name.removeprefix(FUNCTION), self.dataset)


def evaluate_surprises(run: SurpriseRun, output: Path, progress: Progress) -> ClipResult:
    """Write the raw and the centred answer of every question. Raises WmsError if the model cannot be asked."""
    results.check_free(output)
    source, questions, rows = run.surprises(), selected(run.dataset, run.selection), list[Row]()
    sets: dict[tuple[str, ...], dict[int, FilmQuestion]] = {}
    for question in questions:
        sets.setdefault(question.films, {})[question.own] = question
    for question in questions:
        matrix = source.of(question, sets[question.films])
        rows += _rows(run, question, matrix)
        progress(sum(row["right"] for row in rows if row["prompt"] == RAW), len(rows) // 2)
    results.write(output, rows, results_about(run.dataset, run.name, rows), clip_results.SCHEMA)
    return ClipResult(results.counts(rows), "", ())


def _rows(run: SurpriseRun, question: FilmQuestion, matrix: Array) -> Iterator[Row]:
    for reading, values in ((RAW, matrix), (CENTRED, centred(matrix))):
        row = clip_results.common(question, 0, run.name, "", reading, "")
        own = values[question.own]
        place = choice(own)
        yield row | {
            "parsed": place,
            "right": place == question.answer,
            "status": "unparsed" if place is None else "answered",
            "text": "no single least surprise" if place is None else "",
            "distances": [float(value) for value in own],
        }
