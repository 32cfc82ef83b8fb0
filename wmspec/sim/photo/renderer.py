"""The photo renderer: path-traced colours, ids and depth from an engine's renderer."""

from __future__ import annotations

from wmspec.sim.photo.tracer import Tracer
from wmspec.sim.scene.model import Frame, Scene, Shot
from wmspec.sim.scene.model import Renderer as Parity


class PhotoRenderer:
    """Draws one scene; `parity` is an engine's renderer of it and is closed with this one.

    Raises WmsError if Mitsuba is missing.
    """

    def __init__(self, scene: Scene, parity: Parity, size: tuple[int, int], samples: int | None = None) -> None:
        self._tracer, self._parity = Tracer(scene, size, samples), parity

    def draw(self, shot: Shot, *, depth: bool = False) -> Frame:
        """Draw the bodies at the poses of the shot."""
        frame = self._parity.draw(shot, depth=depth)
        return Frame(self._tracer.draw(shot), frame.ids, frame.depth)

    def repaint(self, scene: Scene) -> bool:
        """Switch to a scene that differs in colours only, if the engine's renderer can."""
        if not self._parity.repaint(scene):
            return False
        self._tracer.paint(scene)
        return True

    def close(self) -> None:
        """Release all resources."""
        self._parity.close()
        del self._tracer
