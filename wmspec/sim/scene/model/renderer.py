"""The interface of renderers."""

from __future__ import annotations

from typing import Literal, Protocol

from wmspec.sim.scene.model.cameras import Frame, Shot
from wmspec.sim.scene.model.episode import Scene

Look = Literal["parity", "photo"]
"""`parity` is equal in all engines; `photo` is path-traced by Mitsuba."""


class Renderer(Protocol):
    """Draws one scene any number of times. Close it after use."""

    def draw(self, shot: Shot, *, depth: bool = False) -> Frame:
        """Draw a picture."""
        ...

    def repaint(self, scene: Scene) -> bool:
        """Switch to `scene`, which differs in colours only. Return False if a new renderer is necessary."""
        ...

    def close(self) -> None:
        """Release all resources."""
        ...
