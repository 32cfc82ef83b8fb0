"""The interface of backends, and the metadata that is readable without importing the engine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Literal, Protocol

from wmspec.sim.scene.capability import Lack
from wmspec.sim.scene.model import Renderer, Scene, Trace
from wmspec.sim.scene.physics.episode import kinematic_recording
from wmspec.sim.scene.physics.to_trace import trace


@dataclass(frozen=True)
class Graphics:
    """The graphics API of an engine that does not draw by itself."""

    api: Literal["EGL", "Vulkan"]
    #: The oldest supported Mesa for software rendering.
    mesa: tuple[int, int]
    #: Environment variables that select a driver; other values than the `api` break it.
    variables: tuple[str, ...] = ()


@dataclass(frozen=True)
class Compiled:
    """How pip compiles an engine that has no wheel."""

    #: The newest Python version with a wheel.
    wheels_until: tuple[int, int]
    #: Packages that the build needs.
    needs: tuple[str, ...] = ()
    #: Environment variables of the build, such as `CFLAGS=-O2`.
    variables: str = ""


@dataclass(frozen=True)
class Info:
    """Metadata of an engine; reading it imports no engine."""

    #: The name of the entry point, used on the command line, in traces and in datasets.
    name: str
    #: The official spelling.
    title: str
    #: The Python module.
    module: str
    #: The Python distribution that carries the version.
    distribution: str
    #: The requirement for pip.
    requirement: str
    #: Minimum step rate, Hz, rounded up to a multiple of the sample rate.
    steps_per_second: int
    #: Unsupported and approximated features.
    lacks: tuple[Lack, ...] = ()
    #: Whether the engine draws.
    draws: bool = True
    #: The time to draw a picture relative to MuJoCo's, for the choice of the quickest.
    drawing_cost: float = 10.0
    graphics: Graphics | None = None
    compiled: Compiled | None = None


class Backend(Protocol):
    """The interface of a backend: a module or object named by an entry point of the group `wmspec.backends`.

    Importing it imports no engine, so that `info` is readable without the engine.
    """

    @property
    def info(self) -> Info:
        """Metadata of the engine."""
        ...

    def execute(self, scene: Scene) -> Trace:
        """Execute the episode of a scene.

        Raises WmsError for a scene that the engine does not support, EngineError if the engine fails.
        """
        ...

    def renderer(self, scene: Scene, width: int, height: int) -> Renderer:
        """Return a renderer of the bodies and cameras of a scene.

        Raises WmsError if the engine does not draw, GraphicsError if graphics libraries are missing.
        """
        ...

    def native(self, scene: Scene) -> dict[str, str]:
        """Return the episode in the engine's own format, usable without wmspec: file name -> text."""
        ...


def on_first_use(
    package: str,
) -> tuple[Callable[[Scene], Trace], Callable[[Scene, int, int], Renderer], Callable[[Scene], dict[str, str]]]:
    """Return `execute`, `renderer` and `native` of an engine's package, which import its modules when called.

    These are `physics` with `prepare` and `record`, `render` with `Renderer`, and `export` with `native`.
    """

    def module(name: str) -> Any:
        return import_module(f"{package}.{name}")

    def execute(scene: Scene) -> Trace:
        whole, timeline = module("physics").prepare(scene)
        recording = kinematic_recording(timeline) or module("physics").record(scene, whole, timeline)
        return trace(module("info").INFO.name, scene, timeline, recording)

    return execute, lambda *how: module("render").Renderer(*how), lambda scene: module("export").native(scene)
