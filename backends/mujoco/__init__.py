"""MuJoCo: executes, renders and exports a scene. The engine is imported on first use."""

from __future__ import annotations

from wmspec.sim.scene.model import Renderer, Scene, Trace

from .info import INFO as info

__all__ = ["execute", "info", "native", "renderer"]


def execute(scene: Scene) -> Trace:
    """Return the trace of a scene's episode.

    Raises WmsError for a scene that MuJoCo does not support, EngineError if MuJoCo fails.
    """
    from . import physics

    return physics.execute(scene)


def renderer(scene: Scene, width: int, height: int) -> Renderer:
    """Return a renderer of the bodies and cameras of a scene. Raises GraphicsError if libraries are missing."""
    from . import render

    return render.Renderer(scene, width, height)


def native(scene: Scene) -> dict[str, str]:
    """Return the episode in MuJoCo's own format: file name -> text. Raises WmsError for a scene it lacks."""
    from . import export

    return export.native(scene)
