"""View directions of cameras and bodies."""

from __future__ import annotations

import numpy as np

from wmspec.compile.layout.view import MIN_HORIZONTAL, quarter_turns
from wmspec.core.diagnostics import WmsError
from wmspec.runtime.questions.observed import Observed
from wmspec.sim.scene.model.transform import compose, rotate

_X, _UP, _AHEAD = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, -1.0])


def view_direction(observed: Observed, viewer: str, time: float) -> float:
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
