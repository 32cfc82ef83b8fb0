"""Latent models: how much each future surprises a model that has seen the context.

Of a closed set all contexts and all futures are combined. The raw answer is the future that surprises least. The
centred answer subtracts from every surprise the mean over all contexts, so that a future that is easy to foresee
whatever came before, such as one in which all is at rest, has no advantage.

Of films that are possible or impossible, those with the same beginning and different answers are compared: the one that
surprises more is called impossible. So no threshold is needed, and none is fitted.
"""

from __future__ import annotations

import csv
import importlib
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import read_bytes
from wmspec.dataset.build.films import read_frames
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.build.rows import Row
from wmspec.dataset.film.codec import Frames
from wmspec.dataset.film.distances import Array
from wmspec.eval.clips import results as clip_results
from wmspec.eval.clips.questions import FilmQuestion, film_questions, limited
from wmspec.eval.clips.run import ClipResult, Progress, results_about
from wmspec.eval.models import results
from wmspec.eval.models.question import Selection
from wmspec.lang.check.statements.possibility import IMPOSSIBLE, POSSIBLE

#: Prefixes of latent models and of tables of surprises among models.
FUNCTION, TABLE = "surprise:", "surprises:"
#: How answers are read from surprises: the values of the column `prompt`.
RAW, CENTRED = "raw", "centred"
#: The same for films that are possible or impossible: the surprise counts that of a film's frames on average, or most.
MEAN, MAX = "mean", "max"


class FunctionSurprises:
    """Surprises of a Python function `f(context, future, fps, text)`.

    `context` and `future` are uint8 (T, h, w, 3); the result is a number, or one for each frame of the future, of which
    the mean counts. A class is instantiated once, and its object is called.
    """

    def __init__(self, name: str, dataset: DatasetReader) -> None:
        self._function, self._dataset = _function(name), dataset
        self._known: dict[tuple[str, ...], Array] = {}

    def of(self, question: FilmQuestion, others: dict[int, FilmQuestion]) -> Array:
        """Return the surprises (contexts, futures) of a closed set, in the order of its options; computed once.

        `others` are the questions of the set by the option that is true.
        """
        if question.films not in self._known:
            count = question.answer_frame + 1
            films = [read_frames(self._dataset.folder, path, count=count) for path in question.films]
            texts = [others.get(option, question).text for option in range(len(films))]
            split, rate = question.context, question.rate
            rows = [
                [self._values(shown[:split], film[split:], rate, text).mean() for film in films]
                for shown, text in zip(films, texts, strict=True)
            ]
            self._known = {question.films: np.array(rows)}
        return self._known[question.films]

    def after(self, question: FilmQuestion, split: int) -> Array:
        """Return the surprises (n) of a film after its first `split` frames, or one for all."""
        frames = read_frames(self._dataset.folder, question.film)
        return self._values(frames[:split], frames[split:], question.rate, question.text)

    def _values(self, context: Frames, future: Frames, rate: int, text: str) -> Array:
        value = np.asarray(self._function(context.copy(), future.copy(), rate, text), float)
        if value.ndim > 1 or (value.ndim == 1 and len(value) != len(future)):
            raise WmsError(
                f"the model returned {value.shape} numbers", help=f"return one, or one for each of {len(future)} frames"
            )
        return value.reshape(-1)


class TableSurprises:
    """Surprises in a CSV file with the columns `id`, `place`, `frame` (may be empty) and `surprise`."""

    def __init__(self, path: Path) -> None:
        self._values = _read_table(path)

    def of(self, question: FilmQuestion, others: dict[int, FilmQuestion]) -> Array:
        """Return the surprises in the table; NaN if unknown."""
        count = len(question.films)
        matrix = np.full((count, count), np.nan)
        for option, other in others.items():
            for place in range(count):
                matrix[option, place] = np.mean(self._values.get((other.id, place), [math.nan]))
        return matrix

    def after(self, question: FilmQuestion, split: int) -> Array:  # noqa: ARG002
        """Return the surprises in the table, under the place 0; NaN if unknown."""
        return np.array(self._values.get((question.id, 0), [math.nan]))


#: A source of surprises.
Surprises = FunctionSurprises | TableSurprises


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


def _read_table(path: Path) -> dict[tuple[str, int], list[float]]:
    """Return the surprises by question and place. Raises WmsError for a file that is no such table."""
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
    return values


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

    @cached_property
    def whole(self) -> list[FilmQuestion]:
        """The questions of the dataset whether a film is possible."""
        return list(film_questions(self.dataset, self._ids, "film_split"))

    @cached_property
    def questions(self) -> list[FilmQuestion]:
        """The selected questions with films. Raises WmsError if there are none."""
        every = [*film_questions(self.dataset, self._ids), *self.whole]
        if not every:
            raise WmsError("none of the questions has films: they need `options orbit of ...` or `answer possible`")
        return limited(self.dataset, every, self.selection)

    @cached_property
    def _ids(self) -> list[str]:
        return Selection(self.selection.tasks, self.selection.engines).ids(self.dataset)

    def surprises(self) -> Surprises:
        """Open the model. Raises WmsError if there is none."""
        if self.name.startswith(TABLE):
            return TableSurprises(Path(self.name.removeprefix(TABLE)))
        return FunctionSurprises(self.name.removeprefix(FUNCTION), self.dataset)


def evaluate_surprises(run: SurpriseRun, output: Path, progress: Progress) -> ClipResult:
    """Write the answers of every question with films. Raises WmsError if there are none, or the model fails."""
    results.check_free(output)
    source, rows = run.surprises(), list[Row]()
    questions = [question for question in run.questions if question.films]
    sets: dict[tuple[str, ...], dict[int, FilmQuestion]] = {}
    for question in questions:
        sets.setdefault(question.films, {})[question.own] = question
    for question in questions:
        matrix = source.of(question, sets[question.films])
        rows += _rows(run, question, matrix)
        progress(sum(row["right"] for row in rows if row["prompt"] == RAW), len(rows) // 2)
    pairs = FilmPairs(run.dataset, run.whole)
    for question in (question for question in run.questions if not question.films):
        rows += _possible_rows(run, question, pairs.of(question), source)
        progress(sum(row["right"] for row in rows if row["prompt"] in (RAW, MEAN)), len(rows) // 2)
    results.write(output, rows, results_about(run.dataset, run.name, rows), clip_results.SCHEMA)
    return ClipResult(results.counts(rows), "", ())


def _rows(run: SurpriseRun, question: FilmQuestion, matrix: Array) -> Iterator[Row]:
    for reading, values in ((RAW, matrix), (CENTRED, centred(matrix))):
        row = clip_results.common(question, 0, run.name, "", reading, "")
        own = values[question.own]
        found = clip_results.chosen(choice(own), question.answer, "no single least surprise")
        yield row | found | {"distances": [float(value) for value in own]}


# ---------------------------------------------------------------- possible and impossible films


class FilmPairs:
    """Films with the same beginning, of which some are possible and some are not."""

    def __init__(self, dataset: DatasetReader, questions: list[FilmQuestion]) -> None:
        self._dataset = dataset
        self._groups: dict[tuple[str, str, str, int], list[FilmQuestion]] = {}
        for question in questions:
            self._groups.setdefault(self._key(question), []).append(question)

    def of(self, question: FilmQuestion) -> list[FilmQuestion]:
        """Return the questions of the same group whose film begins alike and whose answer is another."""
        others = (one for one in self._groups[self._key(question)] if _word(one) != _word(question))
        return [one for one in others if self._begin_alike(question, one)]

    def _begin_alike(self, a: FilmQuestion, b: FilmQuestion) -> bool:
        split = min(a.split, b.split)
        x, y = (read_frames(self._dataset.folder, each.film, count=split) for each in (a, b))
        return bool(np.abs(x.astype(np.int16) - y).mean() < _ALIKE)

    @staticmethod
    def _key(question: FilmQuestion) -> tuple[str, str, str, int]:
        return question.task, question.name, question.engine, question.block


#: Mean difference (grey levels) of beginnings that are alike.
_ALIKE = 0.05


def _word(question: FilmQuestion) -> str:
    return question.options[question.answer]


def _possible_rows(
    run: SurpriseRun, question: FilmQuestion, others: list[FilmQuestion], source: Surprises
) -> Iterator[Row]:
    """Yield the answers of a question whether a film is possible: whether it surprises more than others."""
    split = min([question.split, *(one.split for one in others)])
    own, rest = source.after(question, split), [source.after(one, split) for one in others]
    for reading, number in ((MEAN, np.mean), (MAX, np.max)):
        mine, theirs = float(number(own)), float(np.mean([number(each) for each in rest])) if rest else math.nan
        place = None
        if mine != theirs and not math.isnan(mine + theirs):
            place = question.options.index(IMPOSSIBLE if mine > theirs else POSSIBLE)
        row = clip_results.common(question, 0, run.name, "", reading, "")
        found = clip_results.chosen(place, question.answer, "equal surprises" if rest else "no other film begins alike")
        yield row | found | {"distances": [mine, theirs]}
