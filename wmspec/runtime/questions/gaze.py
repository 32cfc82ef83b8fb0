"""Which way a camera or a body looks while things happen."""

from __future__ import annotations

import numpy as np

from wmspec.compile.layout.view import UPRIGHT, quarters
from wmspec.core.diagnostics import WmsError
from wmspec.runtime.questions.observed import Observed
from wmspec.sim.scene.model.transform import compose, rotate

_X, _UP, _AHEAD = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, -1.0])


def gaze(observed: Observed, viewer: str, time: float) -> float:
    """The way that a camera or a body looks at a time (s), in quarter turns anticlockwise from +y.

    A body looks along its own x; a camera that looks straight down, to its upper edge. Raises WmsError for a body that
    looks straight up or down.
    """
    camera = next((camera for camera in observed.scene.cameras if camera.name == viewer), None)
    if camera is None:
        x, y, _ = rotate(observed.pose(viewer, time).orientation, _X)
        if np.hypot(x, y) <= UPRIGHT:
            raise WmsError(f"`{viewer}` looks straight up or down, so nothing is on its left")
        return quarters(x, y)
    pose = camera.pose if camera.body is None else compose(observed.pose(camera.body, time), camera.pose)
    x, y, _ = rotate(pose.orientation, _AHEAD)
    if np.hypot(x, y) <= UPRIGHT:
        x, y, _ = rotate(pose.orientation, _UP)
    return quarters(x, y)
