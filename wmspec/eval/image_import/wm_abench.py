"""Reads the released WM-ABench: Parquet with `source, prompt, choices_str_letter, image_choices, answer`, one task a
folder.

The answer is a position from 0 among image options, and a letter or a position from 1 among options in words.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import is_within, load_image, read_bytes, regular_file
from wmspec.eval.image_import.table import Entry
from wmspec.eval.replies import LETTERS

REQUIRED = ("source", "prompt", "answer")
WORD_OPTIONS, IMAGE_OPTIONS = ("choices_str_letter", "choices"), "image_choices"
#: Words in the names of tasks by their dimension; the first that occurs counts.
_DIMENSIONS = {
    "prediction.compositionality": ("compos",),
    "prediction.transitivity": ("transit",),
    "prediction.mechanistic": ("mechan", "collide", "collision", "slide", "drop", "lift", "push", "nav"),
    "perception.space": ("relation", "occupan", "vacan", "position", "spatial"),
    "perception.time": ("tempor", "duration", "extension"),
    "perception.vision": ("color", "colour", "shape", "material", "vision"),
    "perception.motion": ("motion", "speed", "direction", "trajector", "identif"),
    "perception.quantity": ("quantit", "count", "discrete", "continuous", "relative"),
}
_LABEL = re.compile(r"^\s*[(\[]?([A-Z]|\d{1,2})[)\].:]\s+")


@dataclass(frozen=True)
class Source:
    """The Parquet files of one task, in order, and its name and dimension here."""

    task: str
    dimension: str
    files: tuple[Path, ...]


class Pictures:
    """The pictures of a file by name, decoded when needed and scaled down to sides of at most `size` (px)."""

    def __init__(self, folder: Path, size: int) -> None:
        self._folder, self._size = folder, size
        self._contents: dict[str, bytes | str] = {}

    def add(self, name: str, picture: Any, place: FilePlace) -> str:
        """Keep a picture: its bytes, or the path of a file in the folder. Raises WmsError for anything else."""
        content = picture.get("bytes") or picture.get("path") if isinstance(picture, dict) else picture
        if not isinstance(content, (bytes, str)) or not content:
            raise WmsError("a picture has neither bytes nor a path", place, "download the dataset with its images")
        self._contents[name] = content
        return name

    def still(self, name: str) -> NDArray[np.uint8]:
        """Return a picture (h, w, 3). Raises WmsError if it is missing or damaged."""
        content = self._contents[name]
        if isinstance(content, str):
            named = content
            path = self._folder / named
            if not is_within(self._folder, path):
                raise WmsError(f"`{named}` leads out of the folder", help=f"put it into {self._folder}")
            try:
                content = read_bytes(path)
            except OSError as error:
                raise WmsError(f"`{named}` cannot be read: {error.strerror}", FilePlace(str(path))) from None
        image = load_image(content, "PNG", "JPEG", "WEBP").convert("RGB")
        image.thumbnail((self._size, self._size))
        return np.asarray(image, np.uint8)

    def frames(self, name: str, count: int) -> tuple[list[NDArray[np.uint8]], list[float]]:
        """Not used: the release has no clips."""
        raise NotImplementedError(f"{name} is no clip of {count} frames")


def sources(folder: Path, dimensions: dict[str, str]) -> list[Source]:
    """Return the tasks of a released dataset. `dimensions` gives those of tasks by name.

    Raises WmsError if there is no Parquet file, or for a dimension of an unknown task.
    """
    found: dict[str, list[Path]] = {}
    for path in sorted(folder.rglob("*.parquet")) if folder.is_dir() else ():
        found.setdefault(_task_name(path, folder), []).append(path)
    if not found:
        raise WmsError(f"{folder} holds no Parquet files; give the folder of the downloaded dataset")
    for name in dimensions:
        if name not in found:
            raise WmsError(f"--dimension {name}: the folder has no such task; it has {', '.join(found)}")
    return [Source(name, dimensions.get(name) or _dimension(name), tuple(files)) for name, files in found.items()]


def _task_name(path: Path, folder: Path) -> str:
    """Return a task's name: that of the file without its shard number, or of the folder of a file named by split."""
    stem = re.sub(r"-\d+-of-\d+$", "", path.stem)
    parts = [part for part in path.relative_to(folder).parent.parts if part != "data"]
    words = parts if stem in {"test", "train", "validation", "data"} and parts else [*parts, stem]
    name = re.sub(r"[^a-z0-9]+", "_", "_".join(words).lower()).strip("_")
    return name if name[:1].isalpha() else f"t_{name}"


def _dimension(task: str) -> str:
    return next((name for name, words in _DIMENSIONS.items() if any(word in task for word in words)), "other")


def read_file(source: Source, path: Path, pictures: Pictures, first: int) -> Iterator[Entry]:
    """Yield the questions of a file, numbered from `first`; their pictures are added to `pictures`.

    Raises WmsError, with file and row, if one is invalid.
    """
    try:
        file = pq.ParquetFile(regular_file(path))
        lacking = [name for name in REQUIRED if name not in file.schema_arrow.names]
        if lacking:
            raise WmsError(
                f"it lacks the columns {', '.join(lacking)}", FilePlace(str(path)), "give WM-ABench as released"
            )
        known = [n for n in (*REQUIRED, *WORD_OPTIONS, IMAGE_OPTIONS) if n in file.schema_arrow.names]
        number = 0
        for batch in file.iter_batches(batch_size=64, columns=known):
            for row in batch.to_pylist():
                yield _entry(source, row, pictures, first + number, FilePlace(str(path), number + 1, "row"))
                number += 1
    except (OSError, pa.ArrowException) as error:
        reason = str(error).splitlines()[0]
        raise WmsError(f"cannot be read ({reason})", FilePlace(str(path)), "download it again") from None


def _entry(source: Source, row: dict[str, Any], pictures: Pictures, number: int, place: FilePlace) -> Entry:
    shown = row["source"] if isinstance(row["source"], list) else [row["source"]]
    files = tuple(pictures.add(f"{number}/source/{i}", p, place) for i, p in enumerate(shown) if p is not None)
    images = row.get(IMAGE_OPTIONS) or []
    words = [] if images else _words(next((row[name] for name in WORD_OPTIONS if row.get(name)), None))
    options = tuple(pictures.add(f"{number}/option/{i}", p, place) for i, p in enumerate(images)) or tuple(words)
    if not isinstance(row["prompt"], str) or not row["prompt"].strip():
        raise WmsError("`prompt` is empty", place, "download the dataset again")
    if len(options) < 2 or len(set(options)) < len(options):
        raise WmsError(f"a question has {len(set(options))} different options", place, "it needs two at least")
    answer = _answer(row["answer"], options, bool(images))
    if answer is None:
        raise WmsError(f"`answer` is {str(row['answer'])[:40]!r}, which is none of {len(options)} options", place, "")
    return Entry(
        line=number + 1, task=source.task, dimension=source.dimension, name="", episode="", group="",
        text=row["prompt"].strip(), pictures=files, clip=False, frames=0, times=tuple(map(float, range(len(files)))),
        options=options, pictured=bool(images), answer=answer, value=options[answer] if not images else str(answer),
        number=None, within=None, unit="", difference=None, quantity="", source="WM-ABench (Gao et al., 2025)",
        license="",
    )  # fmt: skip


def _words(choices: Any) -> list[str]:
    """Return options in words from a list, or from a text with a labelled option a line."""
    if isinstance(choices, dict):
        choices = list(choices.values())
    listed: Sequence[Any] = choices if isinstance(choices, list) else re.split(r"\n+|\s*;\s*", choices or "")
    return [_LABEL.sub("", str(word)).strip() for word in listed if str(word).strip()]


def _answer(written: Any, options: tuple[str, ...], pictured: bool) -> int | None:
    """Return the position of the answer, None if it is none of the options."""
    text = str(written).strip().strip("().")
    if not pictured and text in options:
        return options.index(text)
    if len(text) == 1 and text.upper() in LETTERS:
        place = LETTERS.index(text.upper())
    elif re.fullmatch(r"\d{1,2}(?:\.0)?", text):
        place = int(float(text)) - (0 if pictured else 1)
    else:
        return None
    return place if 0 <= place < len(options) else None
