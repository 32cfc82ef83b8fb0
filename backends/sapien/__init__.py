"""SAPIEN: executes, renders and exports a scene."""

from __future__ import annotations

from wmspec.scene.model import Look, Renderer, Scene

from .execute import execute
from .native import native

__all__ = ["execute", "looks", "name", "native", "renderer"]

name = "sapien"
looks: tuple[Look, ...] = ("parity", "beauty")


def renderer(scene: Scene, width: int, height: int, look: Look = "parity", samples: int | None = None) -> Renderer:
    """Make a renderer of the scene's bodies and cameras; only this needs graphics, so only this imports them.

    Raises WmsError where the graphics that the look needs are missing.
    """
    if look == "beauty":
        from . import beauty

        return beauty.Renderer(scene, width, height, samples or beauty.SAMPLES)
    from . import render

    return render.Renderer(scene, width, height)
