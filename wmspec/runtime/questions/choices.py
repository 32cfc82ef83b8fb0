"""Choices among objects by a measure."""

from __future__ import annotations

import numpy as np

from wmspec.compile.layout.functions import extreme_name
from wmspec.compile.layout.view import MIN_HORIZONTAL, common_direction, quarter_turns
from wmspec.core.diagnostics import WmsError
from wmspec.runtime.questions import outcome
from wmspec.runtime.questions.measure import Measured
from wmspec.runtime.questions.observed import Observed
from wmspec.sim.scene.model.transform import compose, rotate

#: What is nearer to a viewer than itself is behind it.
_OPPOSITE = {"in_front_of": "behind", "behind": "in_front_of"}
#: The option for a tie.
NEITHER = "neither"
_X, _UP, _AHEAD = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, -1.0])


def fastest(measured: Measured, names: tuple[str, ...], tie: float | None = None) -> str:
    """Return the object with the highest speed."""
    return extreme_name(measured.each("speed", names), True, tie)


def slowest(measured: Measured, names: tuple[str, ...], tie: float | None = None) -> str:
    """Return the object with the lowest speed."""
    return extreme_name(measured.each("speed", names), False, tie)


def longest(measured: Measured, names: tuple[str, ...], tie: float | None = None) -> str:
    """Return the object that moved for the longest time."""
    return extreme_name(measured.each("moving_time", names), True, tie)


def mover(measured: Measured, names: tuple[str, ...]) -> str:
    """Return the object with the longest path; observation times are equal, so speeds compare like distances."""
    if not any(measured.each("moved", names).values()):
        raise WmsError(f"none of {', '.join(names)} moves, so there is no mover")
    return extreme_name(measured.each("speed", names), True)


def first(measured: Measured, names: tuple[str, ...], tie: float | None = None) -> str:
    """Return the object that moved first."""
    moving = tuple(name for name, moved in measured.each("moved", names).items() if moved)
    onsets = sorted(measured.each("onset", moving).items(), key=lambda pair: pair[1])
    if not onsets and tie is None:
        raise WmsError(f"none of {', '.join(names)} moves, so none is first")
    if not onsets or (tie is not None and len(onsets) > 1 and onsets[1][1] - onsets[0][1] < tie):
        return NEITHER
    return onsets[0][0]


def touches_first(measured: Measured, name: str, others: tuple[str, ...], tie: float | None = None) -> str:
    """Return which of the others it touches first."""
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
    """Return the relation of the first object to the second, as seen by the cameras or by a viewer.

    If the viewer is the second object itself, what is ahead of it is in front of it.
    """
    observed = measured.observed
    time = observed.window[1] if at is None else float(observed.trace.time[observed.moment(at)])
    way = common_direction(measured.values) if seen_from is None else _view_direction(observed, seen_from, time)
    word = outcome.relation(observed, a, b, way, time)
    return _OPPOSITE.get(word, word) if seen_from == b else word


def _view_direction(observed: Observed, viewer: str, time: float) -> float:
    """Return the view direction of a camera or body at a time (s), in quarter turns counter-clockwise from +y.

    A body looks along its x axis; a camera that points straight down, towards its upper edge. Raises WmsError for a
    body that points straight up or down.
    """
    camera = next((camera for camera in observed.scene.cameras if camera.name == viewer), None)
    if camera is None:
        x, y, _ = rotate(observed.pose(viewer, time).orientation, _X)
        if np.hypot(x, y) <= MIN_HORIZONTAL:
            raise WmsError(f"`{viewer}` points straight up or down, so left and right are undefined")
        return quarter_turns(x, y)
    pose = camera.pose if camera.body is None else compose(observed.pose(camera.body, time), camera.pose)
    x, y, _ = rotate(pose.orientation, _AHEAD)
    if np.hypot(x, y) <= MIN_HORIZONTAL:
        x, y, _ = rotate(pose.orientation, _UP)
    return quarter_turns(x, y)
