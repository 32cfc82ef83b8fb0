"""What was observed of an executed episode: the paths of bodies between the first look and the last, and pictures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np

from wmspec.core.diagnostics import WmsError
from wmspec.runtime.questions.views import View
from wmspec.sim.scene.model import Array, Body, Frame, Pose, Scene, Trace
from wmspec.sim.scene.model.bounds import middle, upright
from wmspec.sim.scene.model.transform import identity

#: What gets no further than this (m) from where it was has not moved: engines let things at rest creep by 0.3 mm.
MOVED = 0.002
#: What is slower than this (m/s) stands still. A solver's jitter stays an order of magnitude below.
STILL = 0.01
#: What stands still for so long (s) is at rest.
REST = 0.1


class Observed:
    """An executed `scene` and the `views` of it that are shown. `draw` gives the picture of one (None: none can be)."""

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
        """The first and the last look (s)."""
        times = [time for _, time in self.views]
        return min(times), max(times)

    @cached_property
    def times(self) -> Array:
        """The times (t,) s of the samples in the window."""
        first, last = (self.trace.sample(t) for t in self.window)
        return self.trace.time[first : last + 1]

    def moment(self, at: float | None = None) -> int:
        """The sample nearest to a time (s), the last if there is none. Raises WmsError if it is outside the episode."""
        if at is None:
            return len(self.trace.time) - 1
        end = float(self.trace.time[-1])
        if not -1e-9 <= at <= end + 0.5 / self.scene.rate:
            raise WmsError(f"{at:g} s is outside the episode, which lasts {end:g} s")
        return self.trace.sample(at)

    def span(self, start: float | None, stop: float | None, default: tuple[float, float]) -> slice:
        """The samples from one time (s) to another, those of `default` where there is none.

        Raises WmsError if they are outside the episode, or if it ends before it begins.
        """
        first, last = (
            self.moment(default[0] if start is None else start),
            self.moment(default[1] if stop is None else stop),
        )
        if (start is not None or stop is not None) and last <= first:
            raise WmsError("the span of time that is asked about ends before it begins")
        return slice(first, last + 1)

    @property
    def whole(self) -> tuple[float, float]:
        """The first and the last moment (s) of the episode."""
        return 0.0, float(self.trace.time[-1])

    def index(self, name: str) -> int:
        """Which body of the scene has the name. Raises WmsError if there is none, as where an object is not present."""
        if name not in self._index:
            raise WmsError(f"`{name}` is not there, so nothing can be measured on it; ask only of what is present")
        return self._index[name]

    def body(self, name: str) -> Body:
        """The body of that name. Raises WmsError if there is none."""
        return self.scene.bodies[self.index(name)]

    def track(self, name: str) -> Array:
        """Where the middle of a body's box is (T, 3), m, over the whole episode."""
        i = self.index(name)
        return middle(self.scene.bodies[i], Pose(self.trace.position[:, i], self.trace.orientation[:, i]))

    def path(self, name: str) -> Array:
        """The part (t, 3) of a body's track that was observed."""
        first, last = (self.trace.sample(t) for t in self.window)
        return self.track(name)[first : last + 1]

    def pose(self, name: str, time: float) -> Pose:
        """Where a body's frame is at a time (s)."""
        return self.poses(time)[self.index(name)]

    def poses(self, time: float) -> tuple[Pose, ...]:
        """Where the frames of all bodies are at a time (s)."""
        if time not in self._poses:
            self._poses[time] = self.trace.poses(time)
        return self._poses[time]

    def box(self, name: str, time: float) -> Array:
        """The corners (2, 3) m of the upright box around a body at a time (s)."""
        return upright(self.body(name).geoms, self.pose(name, time))

    def radius(self, name: str) -> float:
        """How far (m) the furthest point of a body's box is from its middle."""
        low, high = upright(self.body(name).geoms, identity())
        return float(np.linalg.norm(high - low)) / 2

    def picture(self, camera: str, time: float) -> Frame:
        """What a camera sees at a time (s). Raises WmsError where nothing can be drawn."""
        if self._draw is None:
            raise WmsError("what is seen can only be measured where pictures are drawn")
        if (camera, time) not in self._seen:
            self._seen[camera, time] = self._draw(camera, time)
        return self._seen[camera, time]

    def views_of(self, camera: str) -> list[View]:
        """The views of a camera. Raises WmsError if there is none."""
        views = [view for view in self.views if view[0] == camera]
        if not views:
            raise WmsError(f"nothing is observed with the camera `{camera}`; write `observe {camera} at [...]`")
        return views


def frame(_observed: Observed, camera: str, time: float) -> View:
    """The picture from a camera at a time (s), which is drawn when it is known which."""
    return camera, time
