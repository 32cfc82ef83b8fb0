"""Reads clips, which are foreign files: one process decodes them, with limits on size, length, time and memory."""

from __future__ import annotations

import os
import resource
from collections.abc import Iterator
from concurrent.futures import TimeoutError as Late
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmspec.core.safe_io import is_within, regular_file
from wmspec.core.signals import defer_signals
from wmspec.dataset.film.codec import Frames, pyav, scaler
from wmspec.dataset.film.distances import WORKING_AREA
from wmspec.eval.clips.normalise import same_aspect
from wmspec.runtime.workers.pool import WorkerContext

#: Largest file (bytes), side (px), length (s) and number of frames of a clip.
MAX_BYTES, MAX_SIDE, MAX_SECONDS, MAX_FRAMES = 64 << 20, 4096, 60.0, 3600
#: Time limit (s) of decoding one clip, and the address space (bytes) of the process.
TIME_LIMIT, MEMORY = 60.0, 6 << 30
#: Frames are scaled down to this area (px); a picture with bars around it still has that of the comparison.
DECODED_AREA = 2 * WORKING_AREA


class BadClip(Exception):
    """A clip that cannot be read; the message is the reason."""


@dataclass(frozen=True)
class Clip:
    """Frames (n, h, w, 3), sRGB, and their times (n) in s, increasing from 0. `size` is the original size (px)."""

    frames: Frames
    times: NDArray[np.float64]
    size: tuple[int, int]


class ClipReader:
    """Reads clips of a folder, in one worker process that is replaced if it crashes or hangs."""

    def __init__(self, pool: Any) -> None:
        self._pool = pool

    def read(self, folder: Path, path: Path, seconds: float, size: tuple[int, int]) -> Clip:
        """Return the first `seconds` of a clip, of which the frames are compared in a size (px).

        Raises BadClip for a file that is missing, foreign or damaged.
        """
        from pebble import ProcessExpired

        if not is_within(folder, path):
            raise BadClip("there is no such file" if not path.is_symlink() else "it is a link that leads elsewhere")
        if (length := path.stat().st_size) > MAX_BYTES:
            raise BadClip(f"it has {length:,} bytes; at most {MAX_BYTES:,}")
        with defer_signals():
            future = self._pool.schedule(decode, args=[str(path), seconds, size], timeout=TIME_LIMIT)
        try:
            clip: Clip = future.result()
        except Late:
            raise BadClip(f"decoding it takes more than {TIME_LIMIT:g} s") from None
        except (ProcessExpired, MemoryError):
            raise BadClip("decoding it needs too much memory or crashes the decoder") from None
        return clip


@contextmanager
def clip_reader() -> Iterator[ClipReader]:
    """Open a reader. Raises WmsError if PyAV is not installed."""
    from pebble import ProcessPool

    pyav()
    pool = ProcessPool(max_workers=1, context=WorkerContext(), initializer=_limit_memory)
    with defer_signals():
        _ = pool.active  # reading this starts the process
    try:
        yield ClipReader(pool)
    finally:
        with defer_signals():
            pool.stop()
            pool.join()


def _limit_memory() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def decode(path: str, seconds: float, compared: tuple[int, int]) -> Clip:
    """Return the first `seconds` of a clip, with the times of its packets, to be `compared` in a size (px).

    Raises BadClip with the reason.
    """
    av = pyav()
    try:
        with (
            regular_file(Path(path)).open("rb") as file,
            av.open(file, options={"protocol_whitelist": "file"}) as container,
        ):
            return _decoded(container, seconds, compared)
    except BadClip:
        raise
    except (av.FFmpegError, OSError, ValueError, ArithmeticError, LookupError, TypeError) as error:
        raise BadClip(f"it cannot be decoded ({str(error)[:200]})".replace(os.fspath(path), "file")) from None


def _decoded(container: Any, seconds: float, compared: tuple[int, int]) -> Clip:
    if not container.streams.video:
        raise BadClip("it has no video")
    stream = container.streams.video[0]
    stream.thread_count = 1
    width, height = stream.codec_context.width, stream.codec_context.height
    if not (8 <= width <= MAX_SIDE and 8 <= height <= MAX_SIDE):
        raise BadClip(f"its frames have {width} x {height} pixels; 8 to {MAX_SIDE} a side")
    scale = min(1.0, (DECODED_AREA / (width * height)) ** 0.5)
    size = max(8, round(width * scale)), max(8, round(height * scale))
    if same_aspect((width, height), compared):
        size = compared
    frames, times, scaled = list[Any](), list[float](), scaler(size)
    nominal = float(stream.average_rate or 24)
    for frame in container.decode(stream):
        time = float(frame.time) if frame.time is not None else len(frames) / nominal
        if times and time - times[0] > min(seconds, MAX_SECONDS):
            break
        if len(frames) >= MAX_FRAMES:
            raise BadClip(f"it has more than {MAX_FRAMES:,} frames in {MAX_SECONDS:g} s")
        if times and time <= times[-1]:
            continue
        times.append(time)
        frames.append(scaled(frame))
    if len(frames) < 2:
        raise BadClip(f"it has {len(frames)} frame{'s' if len(frames) != 1 else ''}")
    return Clip(np.stack(frames), np.array(times) - times[0], (width, height))
