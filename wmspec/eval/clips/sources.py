"""Where clips come from: a folder of a model's files, or a baseline that needs none."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import is_within, read_bytes, regular_file
from wmspec.dataset.build.films import read_frames
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.film.codec import Frames
from wmspec.eval.clips.normalise import Begins
from wmspec.eval.clips.questions import FilmQuestion
from wmspec.eval.clips.read import MAX_BYTES, BadClip, Clip, ClipReader
from wmspec.eval.clips.reference import Reference

#: Suffixes of clips, in the order in which they are searched.
SUFFIXES = (".mp4", ".mkv", ".webm", ".mov", ".avi")
#: The file of a model's own description.
MODEL_FILE = "model.json"
_MOST_SAMPLES = 1000


@dataclass(frozen=True)
class ClipFolder:
    """A folder of clips: `TASK-HASH.mp4`, or `TASK-HASH.0.mp4`, `TASK-HASH.1.mp4` for several samples."""

    folder: Path
    reader: ClipReader
    begins: Begins | None = None

    @property
    def version(self) -> str:
        """The name and version in `model.json`; empty without one. Raises WmsError if it is no JSON object."""
        return " ".join(described(self.folder, key) for key in ("name", "version")).strip()

    def samples(self, question: FilmQuestion) -> list[int]:
        """Return the numbers of the samples of a question; one for a question without files."""
        found = re.compile(rf"{re.escape(question.file_name)}\.(\d{{1,3}})\.\w+")
        numbered = (found.fullmatch(name) for name in self._names)
        numbers = sorted({int(match[1]) for match in numbered if match and int(match[1]) < _MOST_SAMPLES})
        return [0] if self._existing(question.file_name) or not numbers else numbers

    def has_clip(self, question: FilmQuestion) -> bool:
        """Whether there is a clip of a question."""
        stems = (f"{question.file_name}.{sample}" for sample in self.samples(question))
        return any(map(self._existing, (question.file_name, *stems)))

    def digest(self, question: FilmQuestion, sample: int) -> str:
        """Return the SHA-256 of the file of a clip; empty for one that is no file of the folder.

        Raises BadClip if there is none.
        """
        name = self._name(question, sample)
        path = self.folder / name
        with suppress(OSError):
            if is_within(self.folder, path) and regular_file(path).stat().st_size <= MAX_BYTES:
                return hashlib.sha256(read_bytes(path)).hexdigest()
        return ""

    def clip(self, question: FilmQuestion, sample: int, reference: Reference) -> tuple[Clip, Begins | None]:
        """Return a clip, and what it begins with, if that is known.

        Raises BadClip if there is none, or if it cannot be read.
        """
        name = self._name(question, sample)
        seconds = (reference.films[0].context + reference.count) / reference.rate + 1.0
        height, width = reference.plate.shape[:2]
        return self.reader.read(self.folder, self.folder / name, seconds, (width, height)), self.begins

    def unknown(self, questions: list[FilmQuestion]) -> list[str]:
        """Return the clips that belong to none of the questions."""
        known = {question.file_name for question in questions}
        clips = (name for name in self._names if Path(name).suffix.lower() in SUFFIXES)
        return sorted(name for name in clips if re.sub(r"(\.\d{1,3})?\.\w+$", "", name) not in known)

    @property
    def _names(self) -> list[str]:
        return sorted(path.name for path in self.folder.iterdir())

    def _name(self, question: FilmQuestion, sample: int) -> str:
        name = self._existing(question.file_name) or self._existing(f"{question.file_name}.{sample}")
        if not name:
            raise BadClip("there is no clip of this question")
        return name

    def _existing(self, stem: str) -> str:
        names = (f"{stem}{suffix}" for suffix in SUFFIXES)
        return next((n for n in names if (self.folder / n).is_symlink() or (self.folder / n).exists()), "")


def described(folder: Path, key: str) -> str:
    """Return what `model.json` has under a key; empty without it. Raises WmsError if it is no JSON object."""
    path = folder / MODEL_FILE
    try:
        return str(json.loads(read_bytes(path)).get(key) or "")[:100].strip()
    except FileNotFoundError:
        return ""
    except (OSError, ValueError, TypeError, AttributeError, RecursionError):
        raise WmsError("not a JSON object", FilePlace(str(path)), 'write {"name": "...", "version": "..."}') from None


# ---------------------------------------------------------------- baselines


@dataclass(frozen=True)
class Baseline:
    """Clips that are computed from the dataset."""

    name: str
    dataset: DatasetReader
    questions: tuple[FilmQuestion, ...]
    version: str = "1"

    def samples(self, question: FilmQuestion) -> list[int]:  # noqa: ARG002
        """Return the only sample."""
        return [0]

    def digest(self, question: FilmQuestion, sample: int) -> str:  # noqa: ARG002
        """Return the name and version of the baseline, which computes the clip from the dataset."""
        return f"{self.name} {self.version}"

    def clip(self, question: FilmQuestion, sample: int, reference: Reference) -> tuple[Clip, Begins | None]:  # noqa: ARG002
        """Return the clip of a baseline, which begins after the last picture. Raises BadClip if it has none."""
        frames = BASELINES[self.name](self, question, reference)
        return Clip(frames, np.arange(len(frames)) / reference.rate, (frames.shape[2], frames.shape[1])), "after"


#: A source of clips.
Source = ClipFolder | Baseline


def _oracle(source: Baseline, question: FilmQuestion, reference: Reference) -> Frames:  # noqa: ARG001
    return reference.futures[question.own]


def _engine(source: Baseline, question: FilmQuestion, reference: Reference) -> Frames:
    """The true future in another engine."""
    if not question.engines:
        raise BadClip("no other engine has films of this question")
    path = question.film_of(question.own, question.engines[0])
    return read_frames(source.dataset.folder, path)[1 : 1 + reference.count]


def _frozen(source: Baseline, question: FilmQuestion, reference: Reference) -> Frames:  # noqa: ARG001
    film = reference.films[question.own]
    return np.repeat(film.frames[film.context - 1 : film.context], reference.count, axis=0)


def _linear(source: Baseline, question: FilmQuestion, reference: Reference) -> Frames:  # noqa: ARG001
    """Every object keeps the velocity that it has in the last two pictures."""
    film = reference.films[question.own]
    frame, ids = film.frames[film.context - 1], film.ids[film.context - 1]
    before = film.ids[max(film.context - 2, 0)]
    made = np.repeat(
        np.where(np.isin(ids, reference.objects)[..., None], reference.plate, frame)[None], reference.count, 0
    )
    for body in reference.objects:
        here, there = np.argwhere(ids == body), np.argwhere(before == body)
        if not len(here):
            continue
        step = here.mean(axis=0) - there.mean(axis=0) if len(there) else np.zeros(2)
        for t in range(reference.count):
            moved = here + np.rint(step * (t + 1)).astype(int)
            inside = ((moved >= 0) & (moved < ids.shape)).all(axis=1)
            made[t][tuple(moved[inside].T)] = frame[tuple(here[inside].T)]
    return made


def _blend(source: Baseline, question: FilmQuestion, reference: Reference) -> Frames:  # noqa: ARG001
    return np.asarray(np.mean(np.stack(reference.futures), axis=0), np.uint8)


def _swap(source: Baseline, question: FilmQuestion, reference: Reference) -> Frames:
    """The film of another group, of another task if there is one."""
    others = [q for q in source.questions if q.task != question.task] or [
        q for q in source.questions if q.block != question.block
    ]
    if not others:
        raise BadClip("the dataset has no other group")
    other = others[question.index % len(others)]
    frames = read_frames(source.dataset.folder, other.film)[other.context :]
    return frames[np.minimum(np.arange(reference.count), len(frames) - 1)]


BASELINES: dict[str, Callable[[Baseline, FilmQuestion, Reference], Frames]] = {
    "oracle": _oracle,
    "engine": _engine,
    "frozen": _frozen,
    "linear": _linear,
    "blend": _blend,
    "swap": _swap,
}


def open_baseline(name: str, dataset: DatasetReader, questions: list[FilmQuestion]) -> Baseline:
    """Return a baseline. Raises WmsError for an unknown one."""
    if name not in BASELINES:
        raise WmsError(f"there is no baseline `@{name}`; {suggestion(name, BASELINES)}".rstrip("; "))
    return Baseline(name, dataset, tuple(questions))
