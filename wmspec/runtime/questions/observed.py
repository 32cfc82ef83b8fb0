"""Observations of an executed episode: body paths between first and last view, and pictures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np

from wmspec.core.diagnostics import WmsError
from wmspec.runtime.questions.views import View
from wmspec.sim.scene.model import Array, Body, Frame, Pose, Scene, Trace
from wmspec.sim.scene.model.bounds import box_center, world_box
from wmspec.sim.scene.model.transform import identity

#: m: smaller displacements do not count as motion; engines let resting bodies creep by 0.3 mm.
MIN_MOTION = 0.002
#: m/s: slower bodies stand still; solver jitter is an order of magnitude below.
STANDSTILL_SPEED = 0.01
#: s: a standstill of this duration is rest.
REST_TIME = 0.1


class Observed:
    """An executed `scene` and its shown `views`. `draw` returns a picture (None: pictures are unavailable)."""

    def __init__(
        self, scene: Scene, trace: Trace, views: Sequence[View], draw: Callable[[str, float], Frame] | None = None
    ) -> None:
        self.scene = scene
        self.trace = trace
        self.views = tuple(views)
        self._draw = draw
        self._seen: dict[View, Frame] = {}
        self._poses: dict[float, tuple[Pose, ...]] = {}
        self._index = {body.name: i for i, body in enumerate(scene.bodies)}

    @cached_property
    def window(self) -> tuple[float, float]:
        """Times of the first and the last view (s)."""
        times = [time for _, time in self.views]
        return min(times), max(times)

    @cached_property
    def times(self) -> Array:
        """Times (t,) s of the samples in the window."""
        first, last = (self.trace.sample(t) for t in self.window)
        return self.trace.time[first : last + 1]

    def moment(self, at: float | None = None) -> int:
        """Return the sample nearest to a time (s), by default the last. Raises WmsError outside the episode."""
        if at is None:
            return len(self.trace.time) - 1
        end = float(self.trace.time[-1])
        if not -1e-9 <= at <= end + 0.5 / self.scene.rate:
            raise WmsError(f"{at:g} s is outside the episode, which lasts {end:g} s")
        return self.trace.sample(at)

    def span(self, start: float | None, stop: float | None, default: tuple[float, float]) -> slice:
        """Return the samples between two times (s), with `default` for missing ones.

        Raises WmsError if they are outside the episode or in the wrong order.
        """
        first, last = (
            self.moment(default[0] if start is None else start),
            self.moment(default[1] if stop is None else stop),
        )
        if (start is not None or stop is not None) and last <= first:
            raise WmsError("the interval ends before it starts")
        return slice(first, last + 1)

    @property
    def whole(self) -> tuple[float, float]:
        """First and last time (s) of the episode."""
        return 0.0, float(self.trace.time[-1])

    def index(self, name: str) -> int:
        """Return the index of a body. Raises WmsError if it is absent."""
        if name not in self._index:
            raise WmsError(f"`{name}` is absent, so it cannot be measured; use it only where it is present")
        return self._index[name]

    def body(self, name: str) -> Body:
        """Return the body with this name. Raises WmsError if it is absent."""
        return self.scene.bodies[self.index(name)]

    def track(self, name: str) -> Array:
        """Return the centre of a body's box (T, 3), m, over the episode."""
        i = self.index(name)
        return box_center(self.scene.bodies[i], Pose(self.trace.position[:, i], self.trace.orientation[:, i]))

    def path(self, name: str) -> Array:
        """Return the observed part (t, 3) of a track."""
        first, last = (self.trace.sample(t) for t in self.window)
        return self.track(name)[first : last + 1]

    def pose(self, name: str, time: float) -> Pose:
        """Return the pose of a body at a time (s)."""
        return self.poses(time)[self.index(name)]

    def poses(self, time: float) -> tuple[Pose, ...]:
        """Return the poses of all bodies at a time (s)."""
        if time not in self._poses:
            self._poses[time] = self.trace.poses(time)
        return self._poses[time]

    def box(self, name: str, time: float) -> Array:
        """Return the corners (2, 3) m of the axis-aligned box of a body at a time (s)."""
        return world_box(self.body(name).geoms, self.pose(name, time))

    def radius(self, name: str) -> float:
        """Return the distance (m) of the furthest point of a body's box from its centre."""
        low, high = world_box(self.body(name).geoms, identity())
        return float(np.linalg.norm(high - low)) / 2

    def picture(self, camera: str, time: float) -> Frame:
        """Return the picture of a camera at a time (s). Raises WmsError if pictures are unavailable."""
        if self._draw is None:
            raise WmsError("measures of visibility need pictures, which are not drawn here")
        if (camera, time) not in self._seen:
            self._seen[camera, time] = self._draw(camera, time)
        return self._seen[camera, time]

    def views_of(self, camera: str) -> list[View]:
        """Return the views of a camera. Raises WmsError if there are none."""
        views = [view for view in self.views if view[0] == camera]
        if not views:
            raise WmsError(f"nothing is observed with the camera `{camera}`; write `observe {camera} at [...]`")
        return views


def frame(_observed: Observed, camera: str, time: float) -> View:
    """Return the view of a camera at a time (s); it is drawn later."""
    return camera, time
