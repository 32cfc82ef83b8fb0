"""What happened when: touches, and how high something rose. Times (s) are those of samples."""

from __future__ import annotations

import numpy as np

from wmspec.core.diagnostics import WmsError
from wmspec.runtime.questions.observed import MOVED, Observed


def contact(observed: Observed, a: str, b: str, from_: float | None = None, to: float | None = None) -> bool:
    """Whether two bodies touch at any time of the episode, or between two times."""
    return _touched(observed, a, b, from_, to) is not None


def contact_time(observed: Observed, a: str, b: str, from_: float | None = None, to: float | None = None) -> float:
    """When (s) two bodies first touch: the start if they do then. Raises WmsError if they never do."""
    time = _touched(observed, a, b, from_, to)
    if time is None:
        raise WmsError(f"`{a}` and `{b}` do not touch, so there is no time when they first do")
    return time


def highest(observed: Observed, name: str, from_: float | None = None, to: float | None = None) -> float:
    """The greatest height (m) of the middle of a body."""
    return float(observed.track(name)[observed.span(from_, to, observed.whole), 2].max())


def when_highest(observed: Observed, name: str, from_: float | None = None, to: float | None = None) -> float:
    """When (s) the middle of a body is first at its greatest height.

    Raises WmsError if its height changes by no more than 2 mm.
    """
    during = observed.span(from_, to, observed.whole)
    heights = observed.track(name)[during, 2]
    if float(np.ptp(heights)) <= MOVED:
        raise WmsError(f"`{name}` stays at its height, so there is no time when it is highest")
    return float(observed.trace.time[during][heights.argmax()])


def _touched(observed: Observed, a: str, b: str, start: float | None, stop: float | None) -> float | None:
    """The first time (s) of a span at which two bodies touch, the whole episode where there is none; None if never."""
    pair = {observed.body(a).name, observed.body(b).name}
    times = observed.trace.time[observed.span(start, stop, observed.whole)]
    first, last = (float(times[0]), float(times[-1]))
    touches = (c for c in observed.trace.contacts if {c.first, c.second} == pair)
    met = [max(c.start, first) for c in touches if c.stop >= first and c.start <= last]
    return min(met, default=None)
