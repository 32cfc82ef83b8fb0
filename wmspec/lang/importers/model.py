"""What an asset says, in whatever format: links with shapes, joints between them, and what is wrong with it.

Lengths in m, angles in rad, masses in kg.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Literal

from wmspec.core.diagnostics import Diagnostic
from wmspec.core.places import FilePlace
from wmspec.sim.scene.model import Array, Inertia, Pose
from wmspec.sim.shapes import Shape as Solid

Color = tuple[float, float, float]

#: What a spec says of looks goes before all that the file says of them.
LOOKS = ("color", "material", "image")

#: More than that is taken for a mistake, and would take long.
MOST_LINKS, MOST_SHAPES, MOST_FAULTS = 500, 2000, 10

#: The code of all that is wrong with an asset.
ASSET = "WMS210"


@dataclass(frozen=True)
class Conditional:
    """A mistake that does not matter if the spec says one of these properties of the link, or of the whole asset."""

    diagnostic: Diagnostic
    unless: tuple[str, ...]


def conditional(mistakes: Iterable[Diagnostic], unless: tuple[str, ...]) -> tuple[Conditional, ...]:
    """Mistakes that the spec can make good, with this remedy too."""
    return tuple(Conditional(replace(d, help=f"{d.help}, or say `{unless[0]}` in the spec"), unless) for d in mistakes)


class Broken(Exception):
    """An asset that cannot be read any further; the last mistake says why."""


@dataclass
class Faults:
    """All that is wrong with one asset."""

    diagnostics: list[Diagnostic] = field(default_factory=list)

    def add(self, where: FilePlace, message: str, help: str) -> None:
        """Take note of a fault. Raises Broken when there are so many that more would help nobody."""
        self.diagnostics.append(Diagnostic(message, where, help, ASSET))
        if len(self.diagnostics) >= MOST_FAULTS:
            raise Broken

    def stop(self, where: FilePlace, message: str, help: str) -> Broken:
        """A fault after which nothing can be read; raise what this returns."""
        self.diagnostics.append(Diagnostic(message, where, help, ASSET))
        return Broken()

    @contextmanager
    def apart(self) -> Iterator[list[Diagnostic]]:
        """What is wrong meanwhile, which is kept apart from all else."""
        whole, self.diagnostics = self.diagnostics, []
        apart = self.diagnostics
        try:
            yield apart
        except Broken:
            whole += apart
            raise
        finally:
            self.diagnostics = whole


@dataclass(frozen=True)
class Look:
    """How a shape looks: a colour (sRGB), a picture on it, seen from the spec's folder, or both; how glossy it is.

    What is None or empty is not said. The picture is laid out once, or `repeats` times on a metre. `conditional` is
    what cannot be honoured.
    """

    color: Color | None = None
    image: str = ""
    repeats: tuple[float, float] | None = None
    roughness: float | None = None
    metallic: float | None = None
    conditional: tuple[Conditional, ...] = ()


@dataclass(frozen=True)
class MeshFile:
    """A mesh in a file, seen from the spec's folder, `scale` along each of its axes; `collision`: how it is touched."""

    file: str
    scale: tuple[float, ...] = (1.0, 1.0, 1.0)
    collision: str = "hull"


Form = Solid | MeshFile


@dataclass(frozen=True)
class Shape:
    """One geometry of a link, placed in its frame. What is None of how it rubs is as its link says."""

    form: Form
    pose: Pose
    look: Look = field(default_factory=Look)
    solid: bool = True
    drawn: bool = True
    rubs: tuple[float, float] | None = None
    conditional: tuple[Conditional, ...] = ()


@dataclass(frozen=True)
class Link:
    """A rigid body. `where` is where it stands in the file. One without shapes is a mere frame.

    `given` are numbers of the language that the file says of it: `density`, `friction`, `restitution`, `damping`. Its
    `velocity` (3,) m/s and `spin` (3,) rad/s at the start are along the axes of the asset. It goes through those links
    that it `passes`.
    """

    name: str
    where: FilePlace
    shapes: tuple[Shape, ...] = ()
    mass: Inertia | None = None
    given: dict[str, float] = field(default_factory=dict)
    fixed: bool = False
    velocity: Array | None = None
    spin: Array | None = None
    passes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Refused:
    """What is wrong with an asset, and those of its links of which there may be conditional mistakes besides."""

    diagnostics: tuple[Diagnostic, ...]
    links: tuple[Link, ...]


@dataclass(frozen=True)
class Joint:
    """Holds `child` to `parent`. `place` is the child's frame in the parent's with the joint at 0.

    The joint itself is `at` (3,) along `axis` (3,) in the child's frame; the axis of a ball joint or a fixed one means
    nothing. A `free` joint holds nothing. Without a `start` it starts at 0, or at the limit that is nearest to it. Its
    drive goes for the `target` at the speed `pace`, with at most this `strength`; SI units.
    """

    name: str
    where: FilePlace
    kind: Literal["hinge", "slider", "ball", "fixed", "free"]
    parent: str
    child: str
    place: Pose
    at: Array
    axis: Array
    low: float | None = None
    high: float | None = None
    damping: float = 0.0
    stiffness: float = 0.0
    target: float | None = None
    pace: float = 0.0
    strength: float | None = None
    touching: bool = False
    start: float | None = None


@dataclass(frozen=True)
class Asset:
    """A file as it stands: links and joints by name, in the order of the file."""

    links: dict[str, Link]
    joints: dict[str, Joint]
