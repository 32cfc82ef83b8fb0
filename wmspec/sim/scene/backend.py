"""The shape of a backend: what a physics engine offers, and what it says of itself without being imported."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

from wmspec.sim.scene.capability import Lack
from wmspec.sim.scene.model import Renderer, Scene, Trace


@dataclass(frozen=True)
class Graphics:
    """What an engine draws with, where that is not itself."""

    api: Literal["EGL", "Vulkan"]
    #: The oldest Mesa whose software driver will do, where there is no GPU.
    mesa: tuple[int, int]
    #: Environment variables that choose another driver, unless they name the `api`.
    variables: tuple[str, ...] = ()
    #: Whether the driver is chosen as the engine is imported: a wrong choice then spoils executing too.
    on_import: bool = False


@dataclass(frozen=True)
class Compiled:
    """How pip compiles an engine where there is no wheel."""

    #: The newest Python that has a wheel.
    wheels_until: tuple[int, int]
    #: What the build must find installed.
    needs: tuple[str, ...] = ()
    #: Variables before the command, such as `CFLAGS=-O2`.
    variables: str = ""


@dataclass(frozen=True)
class Info:
    """What an engine says of itself. Reading it imports no engine."""

    #: As on the command line, in traces and datasets; the name of the entry point.
    name: str
    #: As its makers write it.
    title: str
    #: The Python module that it is imported as.
    module: str
    #: The Python distribution whose version is the engine's.
    distribution: str
    #: What pip installs to have it.
    requirement: str
    #: At least so many steps are computed a second: a multiple of the scene's rate.
    steps_per_second: int
    #: What scenes may ask for and it can't do.
    lacks: tuple[Lack, ...] = ()
    #: Whether it draws; False if it only executes.
    draws: bool = True
    graphics: Graphics | None = None
    compiled: Compiled | None = None


class Backend(Protocol):
    """What every backend offers: a module, or an object, that an entry point of the group `wmspec.backends` names.

    Importing it imports no engine, so that `info` can be read where the engine is not installed.
    """

    @property
    def info(self) -> Info:
        """What the engine says of itself."""
        ...

    def execute(self, scene: Scene) -> Trace:
        """Run the episode. Raises WmsError for a scene that it can't honour, EngineError when it loses track of it."""
        ...

    def renderer(self, scene: Scene, width: int, height: int) -> Renderer:
        """Make a renderer of the scene's bodies and cameras.

        Raises WmsError if the engine does not draw, GraphicsError if the machine lacks graphics libraries.
        """
        ...

    def native(self, scene: Scene) -> dict[str, str]:
        """The episode in the engine's own form: file name -> text, usable without wmspec."""
        ...
