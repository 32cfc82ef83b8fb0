"""MuJoCo: executes, renders and exports a scene. The engine is imported when it is first used."""

from __future__ import annotations

from wmspec.sim.scene.model import Renderer, Scene, Trace

from .info import INFO as info

__all__ = ["execute", "info", "native", "renderer"]


def execute(scene: Scene) -> Trace:
    """The trace of the scene's episode.

    Raises WmsError for a scene that MuJoCo can't honour, EngineError when MuJoCo loses track of it.
    """
    from . import physics

    return physics.execute(scene)


def renderer(scene: Scene, width: int, height: int) -> Renderer:
    """Make a renderer of the scene's bodies and cameras. Raises GraphicsError where graphics libraries are missing."""
    from . import render

    return render.Renderer(scene, width, height)


def native(scene: Scene) -> dict[str, str]:
    """The episode in MuJoCo's own form: file name -> text. Raises WmsError for a scene that MuJoCo can't honour."""
    from . import export

    return export.native(scene)
