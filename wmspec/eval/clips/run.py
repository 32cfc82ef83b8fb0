"""Evaluates the clips of a video model: reads, measures and scores them, and writes results."""

from __future__ import annotations

import csv
import hashlib
import io
import platform
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pyarrow as pa

from wmspec import __version__
from wmspec.core.diagnostics import WmsError
from wmspec.core.memoize import LRU
from wmspec.core.parquet_io import read_table
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import read_bytes
from wmspec.dataset.build import files
from wmspec.dataset.build.films import read_ids
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.build.rows import Row
from wmspec.dataset.film.distances import object_points, working_size
from wmspec.eval.clips import results as clip_results
from wmspec.eval.clips import sources, strips
from wmspec.eval.clips.decide import track_error
from wmspec.eval.clips.kept import KeptMeasurements
from wmspec.eval.clips.measure import Measurement, align, measure
from wmspec.eval.clips.normalise import Begins
from wmspec.eval.clips.packages import opencv
from wmspec.eval.clips.questions import FilmQuestion, reference_of, selected
from wmspec.eval.clips.read import BadClip, clip_reader
from wmspec.eval.clips.reference import Reference
from wmspec.eval.clips.sam2 import Tracker, open_tracker
from wmspec.eval.models import results
from wmspec.eval.models.question import Selection
from wmspec.eval.models.results import Counts

#: Called after every clip with the number of right ones and the number of clips.
Progress = Callable[[int, int], None]
#: Number of closed sets whose films are in memory.
OPEN_SETS = 2
#: The name of clips among models.
PREFIX = "clips:"
#: Prompts that a model was given, if they were rewritten.
PROMPTS_FILE = "prompts_used.csv"


@dataclass(frozen=True)
class ClipRun:
    """The clips of a folder, or `@NAME` for a baseline, and the questions they answer.

    `masks` names a model that finds the objects, `sam2:FOLDER`; they are found by colour without it.
    """

    dataset: DatasetReader
    place: str
    selection: Selection
    begins: Begins | None = None
    masks: str = ""

    @cached_property
    def name(self) -> str:
        """The name of the model: that in its `model.json`, or of the folder or baseline."""
        folder = Path(self.place)
        own = self.place if self.is_baseline else sources.described(folder, "name") or folder.resolve().name
        return f"{PREFIX}{own}"

    @property
    def is_baseline(self) -> bool:
        """Whether the clips are computed."""
        return self.place.startswith("@")


@dataclass(frozen=True)
class ClipResult:
    """The end of a run: counts, the first error, and clips that belong to no question."""

    counts: Counts
    error: str
    unknown: tuple[str, ...]


def evaluate_clips(run: ClipRun, output: Path, progress: Progress) -> ClipResult:
    """Score every clip and write results and measurements. A clip that cannot be read costs its own row alone.

    A run that was cut off goes on with the same command: clips that it has measured are not measured again.
    Raises WmsError if the dataset has no films, if there are no clips, or if results cannot be written.
    """
    results.check_free(output)
    opencv()
    tracker = open_tracker(run.masks) if run.masks else None
    questions = selected(run.dataset, run.selection)
    rows, measured = list[Row](), dict[tuple[str, int], Measurement]()
    kept = KeptMeasurements(output, run.dataset)
    with _source(run, questions) as source:
        prompt, prompt_hash = _prompts(run)
        model_version = source.version
        references = _References(run.dataset, tracker)
        for question in by_set(questions):
            for sample in source.samples(question):
                row = clip_results.common(question, sample, run.name, model_version, prompt, prompt_hash)
                try:
                    digest = source.digest(question, sample)
                    reference, floors = references.of(question)
                    about = question.id, sample, run.begins, run.masks, digest
                    fresh = partial(_measured, source, question, sample, reference)
                    one = kept.get(about, fresh) if digest else fresh()
                except BadClip as reason:
                    rows.append(clip_results.failed(row, str(reason)))
                else:
                    measured[question.id, sample] = one
                    rows.append(clip_results.scored(row, one, question.rate, floors[question.answer]))
                progress(sum(row["right"] for row in rows), len(rows))
        unknown = tuple(source.unknown(questions)) if isinstance(source, sources.ClipFolder) else ()
        _write_strips(output, rows, {question.id: question for question in questions}, source, references)
    order = {question.id: place for place, question in enumerate(questions)}
    rows.sort(key=lambda row: (order[row["id"]], row["sample"]))
    clip_results.write_tracks(output, measured)
    results.write(output, rows, _about(run, rows, model_version, prompt_hash), clip_results.SCHEMA)
    kept.clear()
    error = next((row["error"] for row in rows if row["status"] == "error"), "")
    return ClipResult(results.counts(rows), error, unknown)


def _measured(source: sources.Source, question: FilmQuestion, sample: int, reference: Reference) -> Measurement:
    clip, begins = source.clip(question, sample, reference)
    return measure(clip, reference, question.own, begins)


@contextmanager
def _source(run: ClipRun, questions: list[FilmQuestion]) -> Iterator[sources.Source]:
    if run.is_baseline:
        yield sources.open_baseline(run.place[1:], run.dataset, questions)
        return
    with clip_reader() as reader:
        folder = Path(run.place)
        if not folder.is_dir():
            raise WmsError(f"there is no folder {folder}", help="give the folder of the model's clips: -m clips:FOLDER")
        source = sources.ClipFolder(folder, reader, run.begins)
        if not any(source.has_clip(question) for question in questions):
            example = f"{questions[0].file_name}.mp4"
            raise WmsError(f"{run.place} has no clip of any question", help=f"name them like `{example}`")
        yield source


def by_set(questions: list[FilmQuestion]) -> list[FilmQuestion]:
    """Return the questions ordered by closed set, so that its films are decoded once."""
    return sorted(questions, key=lambda q: (q.task, q.block, q.engine, sorted(q.films), q.index))


def _write_strips(
    output: Path,
    rows: list[Row],
    questions: dict[str, FilmQuestion],
    source: sources.Source,
    references: _References,
) -> None:
    """Write a picture of the median and the worst clip of each task beside the results."""
    made = []
    for which, row in strips.representative(rows):
        question = questions[row["id"]]
        reference, _ = references.of(question)
        clip, begins = source.clip(question, row["sample"], reference)
        frames = align(clip, reference, question.own, begins).frames
        made.append((strips.caption(which, row), frames, reference.futures[question.own]))
    if made:
        content = io.BytesIO()
        strips.sheet(made).save(content, "PNG")
        results.write_atomically(strips_path(output), content.getvalue())


def strips_path(output: Path) -> Path:
    """Return the path of the film strips of results."""
    return output.with_suffix(".strips.png")


class _References:
    """The films of closed sets, and the distances of the true futures of two engines."""

    def __init__(self, dataset: DatasetReader, tracker: Tracker | None) -> None:
        self._dataset, self._tracker = dataset, tracker
        self._of_sets = LRU[Hashable, tuple[Reference, tuple[tuple[float, float] | None, ...]]](OPEN_SETS)

    def of(self, question: FilmQuestion) -> tuple[Reference, tuple[tuple[float, float] | None, ...]]:
        """Return the films, and for each option the distances of its futures in two engines (None without films)."""
        closed_set = question.films, question.context, question.answer_frame, question.objects
        return self._of_sets.get(closed_set, lambda: self._read(question))

    def _read(self, question: FilmQuestion) -> tuple[Reference, tuple[tuple[float, float] | None, ...]]:
        reference = reference_of(self._dataset, question, self._tracker)
        return reference, tuple(self._floor(question, option, reference) for option in range(len(question.films)))

    def _floor(self, question: FilmQuestion, option: int, reference: Reference) -> tuple[float, float] | None:
        if not question.engines or self._dataset.film is None:
            return None
        size = working_size(*self._dataset.film.size)
        path = question.film_of(option, question.engines[0])
        ids = read_ids(self._dataset.folder, path, size, reference.count + 1)[1:]
        points, _ = object_points(ids, list(reference.objects))
        return track_error(points, reference.points[option], reference.widths)


# ---------------------------------------------------------------- settings


def _prompts(run: ClipRun) -> tuple[str, str]:
    """Return the name and the hash of the prompts that the model was given; the default if the folder has none."""
    path = Path(run.place) / PROMPTS_FILE
    if run.is_baseline or not path.is_file():
        return "film", ""
    try:
        rows = list(csv.DictReader(read_bytes(path).decode("utf-8").splitlines()))
        given = sorted((row["id"], row["text"]) for row in rows)
    except (OSError, UnicodeDecodeError, csv.Error, KeyError, TypeError):
        raise WmsError("expected a table with the columns `id` and `text`", FilePlace(str(path))) from None
    return "rewritten", hashlib.sha256(repr(given).encode()).hexdigest()[:12]


def _about(run: ClipRun, rows: list[Row], model_version: str, prompt_hash: str) -> dict[str, Any]:
    """Return the content of the settings file."""
    about = results_about(run.dataset, run.name, rows)
    about["asked"] |= {"prompt_hash": prompt_hash, "begins": run.begins} | ({"masks": run.masks} if run.masks else {})
    about["clips"] = {"rules": clip_results.RULES_VERSION, "film": run.dataset.manifest["film"]}
    return about | {"model_versions": [model_version] if model_version else []}


def results_about(dataset: DatasetReader, model: str, rows: list[Row]) -> dict[str, Any]:
    """Return the settings of results of a model on films, with the digest of the dataset and the counts."""
    counted, manifest = results.counts(rows), dataset.manifest
    return {
        "format": 1,
        "asked": {"dataset": files.digest(dataset.folder / files.MANIFEST), "model": model},
        "dataset": {key: manifest[key] for key in ("rows", "engines", "seed", "size", "consensus", "versions")},
        "model_versions": [],
        "versions": {"wmspec": __version__, "python": platform.python_version()}
        | {name: version(name) for name in ("av", "numpy")},
        "replies": counted.replies,
        "right": counted.right,
        "status": counted.status,
        "missing": 0,
        "questions": hashlib.sha256("\n".join(row["id"] for row in rows).encode()).hexdigest()[:12],
    }


def rescore_clips(path: Path) -> tuple[Counts, int] | None:
    """Decide the clips of results again, from their measurements; None if the results are not of clips.

    Returns the counts and the number of changed scores. Raises WmsError if the measurements are missing.
    """
    rows, about = results.read(path)
    if "clips" not in about:
        return None
    try:
        rows = read_table(path).cast(clip_results.SCHEMA).to_pylist()
    except (OSError, pa.ArrowException, ValueError):
        raise WmsError("results of another version of wmspec", FilePlace(str(path)), "evaluate again") from None
    again = clip_results.rescore(path, rows)
    about["clips"]["rules"] = clip_results.RULES_VERSION
    about |= {"right": sum(row["right"] for row in again), "status": results.counts(again).status}
    results.write(path, again, about, clip_results.SCHEMA)
    return results.counts(again), sum(a["right"] != b["right"] for a, b in zip(rows, again, strict=True))
