"""Which of several: choices by other measures."""

from __future__ import annotations

from wmspec.compile.layout.functions import extreme
from wmspec.compile.layout.view import front
from wmspec.core.diagnostics import WmsError
from wmspec.runtime.questions import outcome
from wmspec.runtime.questions.gaze import gaze
from wmspec.runtime.questions.measure import Measured

#: What an option can say where two are too near to one another to choose.
NEITHER = "neither"


def fastest(measured: Measured, names: tuple[str, ...], tie: float | None = None) -> str:
    """The one with the largest speed."""
    return extreme(measured.each("speed", names), True, tie)


def slowest(measured: Measured, names: tuple[str, ...], tie: float | None = None) -> str:
    """The one with the smallest speed."""
    return extreme(measured.each("speed", names), False, tie)


def longest(measured: Measured, names: tuple[str, ...], tie: float | None = None) -> str:
    """The one that moved for the longest time."""
    return extreme(measured.each("moving_time", names), True, tie)


def mover(measured: Measured, names: tuple[str, ...]) -> str:
    """The one that travelled furthest. Speeds compare as distances do: all were observed for the same time."""
    if not any(measured.each("moved", names).values()):
        raise WmsError(f"none of {', '.join(names)} moves, so there is no mover")
    return extreme(measured.each("speed", names), True)


def first(measured: Measured, names: tuple[str, ...], tie: float | None = None) -> str:
    """The one that moved first."""
    moving = tuple(name for name, moved in measured.each("moved", names).items() if moved)
    onsets = sorted(measured.each("onset", moving).items(), key=lambda pair: pair[1])
    if not onsets and tie is None:
        raise WmsError(f"none of {', '.join(names)} moves, so none is first")
    if not onsets or (tie is not None and len(onsets) > 1 and onsets[1][1] - onsets[0][1] < tie):
        return NEITHER
    return onsets[0][0]


def touches_first(measured: Measured, name: str, others: tuple[str, ...], tie: float | None = None) -> str:
    """Which of the others it touches first."""
    touched = [other for other in others if measured.call("contact", (name, other))]
    times = sorted((float(measured.call("contact_time", (name, other))), other) for other in touched)
    if not times and tie is None:
        raise WmsError(f"`{name}` touches none of {', '.join(others)}, so none is first")
    if not times or (tie is not None and len(times) > 1 and times[1][0] - times[0][0] < tie):
        return NEITHER
    if len(times) > 1 and times[0][0] == times[1][0]:
        raise WmsError(f"`{name}` touches {times[0][1]} and {times[1][1]} at once, so neither is first")
    return times[0][1]


def relation(measured: Measured, a: str, b: str, at: float | None = None, seen_from: str | None = None) -> str:
    """Where the first is from the second, as the cameras show it or as a viewer sees it."""
    observed = measured.observed
    time = observed.window[1] if at is None else float(observed.trace.time[observed.moment(at)])
    way = front(measured.values) if seen_from is None else gaze(observed, seen_from, time)
    return outcome.relation(observed, a, b, way, time)
