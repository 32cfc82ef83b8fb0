"""The shape of a backend."""

from __future__ import annotations

from typing import Literal, Protocol

from wmspec.scene.model.cameras import Frame, Shot
from wmspec.scene.model.episode import Scene, Trace

Look = Literal["parity", "beauty"]
"""The same picture from every engine, or the best that each can draw."""


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


class Backend(Protocol):
    """What every package under `backends/` offers, by the same names."""

    name: str
    looks: tuple[Look, ...]

    def execute(self, scene: Scene) -> Trace:
        """Run the episode."""
        ...

    def renderer(
        self, scene: Scene, width: int, height: int, look: Look = "parity", samples: int | None = None
    ) -> Renderer:
        """Make a renderer of the scene's bodies and cameras; `samples` a pixel are for the look "beauty".

        Raises WmsError if the engine does not have the look, or the machine not the graphics.
        """
        ...

    def native(self, scene: Scene) -> dict[str, str]:
        """The episode in the engine's own form: file name -> text, usable without wmspec."""
        ...
