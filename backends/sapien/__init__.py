"""SAPIEN: executes, renders and exports a scene."""

from __future__ import annotations

from wmspec.backends.sapien.execute import execute
from wmspec.backends.sapien.native import native
from wmspec.scene.model import Renderer, Scene

__all__ = ["execute", "name", "native", "renderer"]

name = "sapien"


def renderer(scene: Scene, width: int, height: int) -> Renderer:
    """Make a renderer of the scene's bodies and cameras; only this needs graphics, so only this imports them."""
    from wmspec.backends.sapien import render

    return render.renderer(scene, width, height)
