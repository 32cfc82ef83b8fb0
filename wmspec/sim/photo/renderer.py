"""The photo look of a scene: colours by paths of light, bodies and distances by an engine's renderer."""

from __future__ import annotations

from wmspec.sim.photo.tracer import Tracer
from wmspec.sim.scene.model import Frame, Scene, Shot
from wmspec.sim.scene.model import Renderer as Parity


class Renderer:
    """Draws one scene; `parity` is an engine's renderer of it, which is closed with this one.

    Raises WmsError if Mitsuba is missing.
    """

    def __init__(self, scene: Scene, parity: Parity, size: tuple[int, int], samples: int | None = None) -> None:
        self._tracer, self._parity = Tracer(scene, size, samples), parity

    def draw(self, shot: Shot, *, depth: bool = False) -> Frame:
        """Draw the bodies where the shot places them."""
        frame = self._parity.draw(shot, depth=depth)
        return Frame(self._tracer.draw(shot), frame.ids, frame.depth)

    def repaint(self, scene: Scene) -> bool:
        """Draw a scene from now on that differs in colours only, if the engine's renderer can."""
        if not self._parity.repaint(scene):
            return False
        self._tracer.paint(scene)
        return True

    def close(self) -> None:
        """Let go of everything."""
        self._parity.close()
        del self._tracer
