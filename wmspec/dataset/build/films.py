"""Reads the films of a dataset folder."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import is_within, read_bytes
from wmspec.dataset.build.images import encode_png
from wmspec.dataset.build.reader import REPAIR_HINT
from wmspec.dataset.film.codec import CONTAINER, NO_PROBING, Frames, Ids, encode_mp4, pyav, scaler
from wmspec.dataset.film.distances import nearest_pixels


def read_frames(folder: Path, path: str, size: tuple[int, int] | None = None, count: int | None = None) -> Frames:
    """Return the frames (n, h, w, 3) of a film, or its first `count`, in its own size or scaled to `size` (px).

    Raises WmsError if the film is missing, damaged, or outside the folder.
    """
    return _decoded(folder, path, scaler(size), count)


def read_ids(folder: Path, path: str, size: tuple[int, int], count: int | None = None) -> Ids:
    """Return the body of each pixel (n, h, w), -1 for none, of a film at `path`, or of its first `count` frames.

    Each pixel of the `size` (px) is the nearest one. Raises WmsError as `read_frames`.
    """

    def shrunk(frame: Any) -> Ids:
        # In the order green, blue, red. Rows of a plane are padded.
        low, high = (_plane(frame.planes[k], frame.width, frame.height) for k in (2, 0))
        made = nearest_pixels(low, size)
        if high.any():  # from 255 bodies on
            made = made + np.left_shift(nearest_pixels(high, size), 8, dtype=np.int16)
        # The numbers of few bodies fit in a byte, which halves the time of what follows.
        return np.asarray(made.astype(np.int8 if made.max() <= np.iinfo(np.int8).max else np.int16) - 1)

    return _decoded(folder, f"{path.removesuffix('.mkv')}.ids.mkv", shrunk, count)


def _plane(plane: Any, width: int, height: int) -> NDArray[np.uint8]:
    return np.frombuffer(plane, np.uint8).reshape(-1, plane.line_size)[:height, :width]


def _decoded(folder: Path, path: str, made: Callable[[Any], NDArray[Any]], count: int | None) -> NDArray[Any]:
    """Return what is `made` of the frames of a film, or of its first `count`."""
    av = pyav()
    file = folder / path
    if not is_within(folder, file):
        raise WmsError("this film is missing", FilePlace(str(file)), REPAIR_HINT)
    try:
        with av.open(io.BytesIO(read_bytes(file)), format=CONTAINER, options=NO_PROBING) as container:
            stream = container.streams.video[0]
            stream.thread_count = 1
            frames = [made(frame) for frame in islice(container.decode(stream), count)]
        return np.stack(frames)
    except (OSError, av.FFmpegError, IndexError, ValueError) as error:
        raise WmsError(f"a damaged film ({error})", FilePlace(str(file)), REPAIR_HINT) from None


@dataclass(frozen=True)
class ShownFilm:
    """The part of a film that a question shows: `count` frames, `rate` a second, from `start` (s) on, of one camera.

    `scene` describes it in words. The answer is seen `wait` (s) after its last frame; None if the question is whether
    the film is possible.
    """

    folder: Path
    path: str
    camera: str
    rate: int
    start: float
    count: int
    scene: str
    wait: float | None

    @property
    def text(self) -> str:
        """The question about the film; the text of the row is about the pictures."""
        if self.wait is None:
            return f"{self.scene} Is what the film shows possible?".strip()
        return f"{self.scene} Which picture shows the scene {self.wait:.2g} seconds after the end of the film?"

    @property
    def end(self) -> float:
        """The time (s) of the last frame."""
        return self.start + (self.count - 1) / self.rate

    def pictures(self, most: int) -> list[tuple[float, bytes]]:
        """Return the times (s) and pictures (PNG) of at most `most` frames, evenly spaced, the first and last included.

        Raises WmsError if the film is damaged.
        """
        frames = read_frames(self.folder, self.path, count=self.count)
        chosen = np.linspace(0, len(frames) - 1, min(most, len(frames))).round().astype(int)
        return [(self.start + float(k) / self.rate, encode_png(frames[k])) for k in chosen]

    def mp4(self, *, whole: bool = False) -> bytes:
        """Return the film as an MP4 in real time, with `whole` also what then happens.

        Raises WmsError if it is damaged.
        """
        return encode_mp4(read_frames(self.folder, self.path, count=None if whole else self.count), self.rate)


def shown_film(folder: Path, row: dict[str, Any]) -> ShownFilm | None:
    """Return the film that a dataset row shows; None for a row without."""
    if not row.get("film"):
        return None
    camera = row.get("film_camera", "")  # the first datasets with films do not say it
    rate, count = row["film_rate"], row["film_context"]
    wait = (row["film_answer"] - count + 1) / rate - row["film_offset"] if row["option_film"] else None
    return ShownFilm(folder, row["film"], camera, rate, row["film_start"], count, row["film_text"], wait)
