"""Newton as an engine of wmspec: executes and exports a scene. The engine is imported on first use."""

from __future__ import annotations

from collections.abc import Sequence

from wmspec.core.diagnostics import WmsError
from wmspec.sim.scene.backend import on_first_use
from wmspec.sim.scene.model import Renderer, Scene, Trace

from .info import INFO as info

__all__ = ["execute", "execute_all", "info", "native", "renderer"]
__version__ = "0.2.0"

execute, _, native = on_first_use(__name__)


def execute_all(scenes: Sequence[Scene], device: str | None = None) -> list[Trace]:
    """Return the traces of scenes, those of equal structure executed together, as worlds of one model.

    `device` of Warp: by default the GPU, if there is one, else the processor. Raises WmsError for a scene that Newton
    does not support, EngineError if Newton fails.
    """
    from . import batch

    return batch.execute_all(scenes, device)


def renderer(scene: Scene, width: int, height: int) -> Renderer:  # noqa: ARG001  the interface of engines
    """Raise WmsError: another engine draws."""
    raise WmsError("Newton does not draw for wmspec; name another engine with --renderer")
