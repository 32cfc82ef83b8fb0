"""The shape of what draws."""

from __future__ import annotations

from typing import Literal, Protocol

from wmspec.sim.scene.model.cameras import Frame, Shot
from wmspec.sim.scene.model.episode import Scene

Look = Literal["parity", "photo"]
"""The same picture from every engine, or a path-traced one by Mitsuba, for people."""


class Renderer(Protocol):
    """Draws one scene, any number of times. Close it when done."""

    def draw(self, shot: Shot, *, depth: bool = False) -> Frame:
        """Draw a picture of the shot."""
        ...

    def repaint(self, scene: Scene) -> bool:
        """Draw `scene` from now on, which differs in colours only; False if that takes a new renderer."""
        ...

    def close(self) -> None:
        """Let go of everything."""
        ...
