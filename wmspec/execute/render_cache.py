"""Drawing scenes: a renderer is kept for as long as scenes look the same, and a picture is drawn once."""

from __future__ import annotations

import hashlib
import pickle
from collections import OrderedDict
from typing import Any

from wmspec.execute.backends import backend
from wmspec.scene.model import Frame, Look, Renderer, Scene, Shot


def look_key(scene: Scene) -> str:
    """What a picture shows of a scene apart from poses, as a hash."""
    return _hash(form_key(scene), [[g.surface for g in b.geoms if g.visible] for b in scene.bodies])


def form_key(scene: Scene) -> str:
    """What a picture shows of a scene apart from poses and colours, as a hash."""
    shown = [
        (
            b.name,
            b.motion,
            [(g.shape, g.pose, g.surface.texture, g.surface.repeats, g.collides) for g in b.geoms if g.visible],
        )
        for b in scene.bodies
    ]
    return _hash(shown, scene.cameras, scene.light, scene.background)


def _hash(*read: Any) -> str:
    return hashlib.blake2b(pickle.dumps(read, protocol=4), digest_size=16).hexdigest()


class RenderCache:
    """Draws in one engine at one size (pixels), in a look, with so many samples a pixel. Close it when done."""

    def __init__(
        self,
        engine: str,
        width: int,
        height: int,
        look: Look = "parity",
        samples: int | None = None,
        remembered: int = 64,
    ) -> None:
        self.engine = engine
        self.size = (width, height)
        self._look, self._samples = look, samples
        self._remembered = remembered
        self._open: tuple[str, str, Renderer] | None = None
        self._frames: OrderedDict[str, Frame] = OrderedDict()

    def draw(self, scene: Scene, shot: Shot, *, depth: bool = False) -> Frame:
        """The picture of a scene from a camera, with every body at the pose of the shot."""
        look = look_key(scene)
        where = b"".join(p.position.tobytes() + p.orientation.tobytes() for p in shot.poses)
        key = hashlib.blake2b(f"{look}{shot.camera}{depth}".encode() + where, digest_size=16).hexdigest()
        if key not in self._frames:
            self._frames[key] = self._renderer(scene, look).draw(shot, depth=depth)
            if len(self._frames) > self._remembered:
                self._frames.popitem(last=False)
        self._frames.move_to_end(key)
        return self._frames[key]

    def close(self) -> None:
        """Let go of the renderer."""
        if self._open is not None:
            self._open[2].close()
            self._open = None

    def _renderer(self, scene: Scene, look: str) -> Renderer:
        form = form_key(scene)
        if self._open is not None and self._open[0] != look and not self._repainted(scene, form):
            self.close()
        if self._open is None:
            renderer = backend(self.engine).renderer(scene, *self.size, self._look, self._samples)
        else:
            renderer = self._open[2]
        self._open = (look, form, renderer)
        return renderer

    def _repainted(self, scene: Scene, form: str) -> bool:
        """Whether the renderer that is open could be given the colours of the scene."""
        return self._open is not None and self._open[1] == form and self._open[2].repaint(scene)
