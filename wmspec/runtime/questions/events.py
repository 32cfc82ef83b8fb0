"""Events: contacts, and greatest heights. Times (s) are those of samples."""

from __future__ import annotations

import numpy as np

from wmspec.core.diagnostics import WmsError
from wmspec.runtime.questions.observed import MIN_MOTION, Observed
from wmspec.sim.scene.physics.kinematic_contact import first_touch, moves_freely


def contact(observed: Observed, a: str, b: str, from_: float | None = None, to: float | None = None) -> bool:
    """Return whether two bodies touch at any time, or within an interval."""
    return _touched(observed, a, b, from_, to) is not None


def contact_time(observed: Observed, a: str, b: str, from_: float | None = None, to: float | None = None) -> float:
    """Return the time (s) at which two bodies first touch; the start if they touch then. Raises WmsError if they never
    do.
    """
    time = _touched(observed, a, b, from_, to)
    if time is None:
        raise WmsError(f"`{a}` and `{b}` do not touch, so they have no contact time")
    return time


def highest(observed: Observed, name: str, from_: float | None = None, to: float | None = None) -> float:
    """Return the greatest height (m) of the centre of a body."""
    return float(observed.track(name)[observed.span(from_, to, observed.whole), 2].max())


def when_highest(observed: Observed, name: str, from_: float | None = None, to: float | None = None) -> float:
    """Return the time (s) at which the centre of a body first reaches its greatest height.

    Raises WmsError if the height changes by at most 2 mm.
    """
    during = observed.span(from_, to, observed.whole)
    heights = observed.track(name)[during, 2]
    if float(np.ptp(heights)) <= MIN_MOTION:
        raise WmsError(f"`{name}` stays at its height, so it has no highest moment")
    return float(observed.trace.time[during][heights.argmax()])


def _touched(observed: Observed, a: str, b: str, start: float | None, stop: float | None) -> float | None:
    """Return the first time (s) of contact within an interval (default: the episode), or None."""
    samples = observed.span(start, stop, observed.whole)
    if not moves_freely(observed.body(a), observed.body(b)):
        return first_touch(observed.scene, observed.trace, a, b, samples)
    pair = {a, b}
    times = observed.trace.time[samples]
    first, last = (float(times[0]), float(times[-1]))
    touches = (c for c in observed.trace.contacts if {c.first, c.second} == pair)
    met = [max(c.start, first) for c in touches if c.stop >= first and c.start <= last]
    return min(met, default=None)
