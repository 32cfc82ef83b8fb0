"""Renders scenes: renderers are reused for scenes that differ in colours and poses only, and pictures are cached."""

from __future__ import annotations

from dataclasses import dataclass

from wmspec.core.memoize import LRU
from wmspec.runtime.caches.cache_keys import form_key, look_key, shot_key
from wmspec.runtime.engines.registry import backend
from wmspec.sim.scene.model import Frame, Look, Renderer, Scene, Shot

#: Cache size of pictures (bytes), and maximum number of open renderers.
MAX_PICTURE_BYTES, MAX_OPEN_RENDERERS = 96_000_000, 4


class RenderCache:
    """Renders in one engine at one size (pixels), in a look, with a number of samples per pixel. Close it after use.

    `requests` counts requested pictures, `drawn` those that were rendered.
    """

    def __init__(
        self,
        engine: str,
        width: int,
        height: int,
        look: Look = "parity",
        samples: int | None = None,
        remembered: int = MAX_PICTURE_BYTES,
    ) -> None:
        self.engine = engine
        self.size = (width, height)
        self.requests = self.drawn = 0
        self._look, self._samples = look, samples
        self._frames: LRU[tuple[bytes, bytes, bool], Frame] = LRU(remembered, weigh=_bytes)
        self._open: LRU[bytes, _Open] = LRU(MAX_OPEN_RENDERERS, drop=lambda one: one.renderer.close())

    def draw(self, scene: Scene, shot: Shot, *, depth: bool = False) -> Frame:
        """Return the picture of a scene from a camera, with every body at the pose of the shot."""
        key = look_key(scene), shot_key(shot), depth
        self.requests += 1
        return self._frames.get(key, lambda: self._drawn(scene, shot, depth))

    def close(self) -> None:
        """Close the renderers."""
        self._open.clear()

    def _drawn(self, scene: Scene, shot: Shot, depth: bool) -> Frame:
        self.drawn += 1
        return self._renderer(scene).draw(shot, depth=depth)

    def _renderer(self, scene: Scene) -> Renderer:
        """Return a renderer of the scene: an open one that accepts its colours, or a new one."""
        form, look = form_key(scene), look_key(scene)
        one = self._open.get(form, lambda: _Open(self._new_renderer(scene), look))
        if one.look != look and not one.renderer.repaint(scene):
            self._open.pop(form).renderer.close()
            one = self._open.put(form, _Open(self._new_renderer(scene), look))
        one.look = look
        return one.renderer

    def _new_renderer(self, scene: Scene) -> Renderer:
        parity = backend(self.engine).renderer(scene, *self.size)
        if self._look == "parity":
            return parity
        from wmspec.sim.photo.tracer import PhotoRenderer as Photo

        return Photo(scene, parity, self.size, self._samples)


@dataclass
class _Open:
    """A renderer that is open, and the colours that it has."""

    renderer: Renderer
    look: bytes


def _bytes(frame: Frame) -> int:
    return int(frame.rgb.nbytes + frame.ids.nbytes + (0 if frame.depth is None else frame.depth.nbytes))
