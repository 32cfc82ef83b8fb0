"""The frames of a film: a grid of times through the last frame of the context."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from wmspec.core.diagnostics import WmsError

#: Permitted frame rates (Hz): common rates that divide the 240 samples of a second.
RATES = (8, 12, 16, 24, 30, 60)
#: Default width and height (px).
DEFAULT_SIZE = (832, 480)
#: Longest film (frames).
MAX_FRAMES = 1200
#: Longest time (s) that a film goes on after the context.
MAX_SECONDS = 60
_EPSILON = 1e-6


@dataclass(frozen=True)
class FilmSettings:
    """The rate (Hz) and the size (px) of the films of a dataset, and the least length (s) of what follows the context.

    Raises WmsError for settings that are invalid.
    """

    rate: int
    size: tuple[int, int] = DEFAULT_SIZE
    seconds: float | None = None

    def __post_init__(self) -> None:
        if self.rate not in RATES:
            raise WmsError(f"{self.rate} frames per second", help=f"choose one of {', '.join(map(str, RATES))}")
        if any(side % 2 for side in self.size):
            raise WmsError(
                f"film size {self.size[0]}x{self.size[1]}: video codecs need even sides", help="such as 832x480"
            )
        if self.seconds is not None and not 0 < self.seconds <= MAX_SECONDS:
            raise WmsError(f"films that go on for {self.seconds:g} s", help=f"at most {MAX_SECONDS} s")

    @property
    def record(self) -> dict[str, Any]:
        """The settings as JSON values."""
        longer = {} if self.seconds is None else {"seconds": self.seconds}
        return {"rate": self.rate, "size": list(self.size), **longer}

    @classmethod
    def of(cls, record: dict[str, Any] | None) -> FilmSettings | None:
        """Return the settings of JSON values; None for None."""
        if record is None:
            return None
        return cls(record["rate"], (record["size"][0], record["size"][1]), record.get("seconds"))


@dataclass(frozen=True)
class FilmTimes:
    """The times (s) of all frames.

    The first `context` of them are shown. Frame `answer_frame` is nearest to the answer, `offset` (s) later. Of a film
    that is shown whole, the first `split` come before what may be impossible.
    """

    times: tuple[float, ...]
    context: int
    answer_frame: int
    offset: float
    split: int | None = None


def shown_times(start: float, last: float, before: float, rate: int) -> FilmTimes:
    """Return the frames from `start` to `last` (s), all of which are shown; `split` counts those up to `before` (s).

    Raises WmsError for a film that is too long, or has no frame up to `before` or none after it.
    """
    count = int((last - start) * rate + _EPSILON) + 1
    if not 2 <= count <= MAX_FRAMES:
        raise WmsError(f"the film has {count:,} frames; 2 to {MAX_FRAMES:,} are possible")
    times = tuple(max(last + k / rate, 0.0) for k in range(1 - count, 1))
    split = sum(time <= before + _EPSILON for time in times)
    if not 0 < split < count:
        raise WmsError(f"the film, from {start:g} s to {last:g} s, does not begin before {before:g} s and end after it")
    return FilmTimes(times, count, count - 1, 0.0, split)


def film_times(start: float, last: float, answer: float, rate: int, seconds: float | None = None) -> FilmTimes:
    """Return the frames from `start` to the `answer` (s), one of them exactly at `last`, the end of the context.

    With `seconds`, the film goes on at least so long after the context.
    Raises WmsError for a film that is empty, too long, or ends at or after the answer.
    """
    if not 0 <= start <= last + _EPSILON:
        raise WmsError(f"the film ends at {last:g} s, before it begins at {start:g} s")
    before = int((last - start) * rate + _EPSILON)
    after = int((answer - last) * rate + _EPSILON)
    if after < 1:
        raise WmsError(f"the film ends at {last:g} s; the answer at {answer:g} s is less than one frame later")
    whole = max(after, round((seconds or 0) * rate))
    if before + whole >= MAX_FRAMES:
        raise WmsError(f"the film has {before + whole + 1:,} frames; at most {MAX_FRAMES:,}")
    times = tuple(max(last + k / rate, 0.0) for k in range(-before, whole + 1))
    return FilmTimes(times, before + 1, before + after, times[before + after] - answer)
