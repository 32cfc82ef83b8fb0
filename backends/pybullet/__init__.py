"""PyBullet: executes, renders and exports a scene."""

from __future__ import annotations

from wmspec.diagnostics import WmsError
from wmspec.scene.model import Look, Renderer, Scene

from .execute import execute
from .native import native

__all__ = ["execute", "looks", "name", "native", "renderer"]

name = "pybullet"
looks: tuple[Look, ...] = ("parity",)


def renderer(scene: Scene, width: int, height: int, look: Look = "parity", samples: int | None = None) -> Renderer:
    """Make a renderer of the scene's bodies and cameras.

    Raises WmsError for another look than parity, which is all that TinyRenderer can.
    """
    if look not in looks or samples is not None:
        raise WmsError(f"PyBullet can't draw the look '{look}'; let mujoco or sapien draw, with `--renderer`")
    from . import render

    return render.Renderer(scene, width, height)
