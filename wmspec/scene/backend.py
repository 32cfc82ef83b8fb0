"""The shape of a backend: what a physics engine offers, and what it says of itself without being imported."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

from wmspec.diagnostics import WmsError
from wmspec.scene.capability import Lack
from wmspec.scene.model import Look, Renderer, Scene, Trace


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
    #: What it can draw; nothing, if it only executes.
    looks: tuple[Look, ...]
    #: What scenes may ask for and it can't do.
    lacks: tuple[Lack, ...] = ()
    graphics: Graphics | None = None
    compiled: Compiled | None = None


def must_draw(info: Info, look: Look, samples: int | None) -> None:
    """Raises WmsError unless the engine draws the look itself, with so many samples a pixel if any are asked for."""
    if look == "photo":
        raise WmsError(
            f"{info.title} doesn't draw the look 'photo', Mitsuba does for any engine; ask for it with `--look photo`, "
            'or in Python with `look="photo"` where pictures are drawn or a `RenderCache` is made'
        )
    if look not in info.looks:
        raise WmsError(f"{info.title} can't draw the look '{look}'; let another engine draw, with `--renderer`")
    if look == "parity" and samples is not None:
        raise WmsError("the look 'parity' has no samples to choose; leave them out, or draw the look 'beauty'")


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

    def renderer(
        self, scene: Scene, width: int, height: int, look: Look = "parity", samples: int | None = None
    ) -> Renderer:
        """Make a renderer of the scene's bodies and cameras; `samples` a pixel are for the look "beauty".

        Raises WmsError if the engine does not have the look, or the machine not the graphics.
        """
        ...

    def native(self, scene: Scene) -> dict[str, str]:
        """The episode in the engine's own form: file name -> text, usable without wmspec."""
        ...
