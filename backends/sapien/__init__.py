"""SAPIEN: executes, renders and exports a scene. The engine is imported on first use."""

from wmspec.sim.scene.backend import on_first_use

from .info import INFO as info

__all__ = ["execute", "info", "native", "renderer"]

execute, renderer, native = on_first_use(__name__)
