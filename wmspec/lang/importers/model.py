"""Format-independent model of assets: links with shapes, joints, and what is wrong with them.

Lengths in m, angles in rad, masses in kg. A feature of a file is read exactly, or approximated or left out with a
warning, or refused with an error. What bears neither on motion nor on pictures is ignored.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Literal

from wmspec.core.diagnostics import Diagnostic
from wmspec.core.places import FilePlace
from wmspec.lang.check.library.expand import APPROXIMATION
from wmspec.sim.scene.model import Array, Inertia, Pose
from wmspec.sim.shapes import Shape as Solid

Color = tuple[float, float, float]

#: Properties of the spec that override the file's appearance.
OVERRIDING_PROPERTIES = ("color", "material", "image")

#: Limits of an asset: larger ones are rejected as mistakes.
MAX_LINKS, MAX_SHAPES = 500, 2000
#: Number of faults after which reading stops, and number of their kinds that are reported.
MAX_FAULTS, MAX_KINDS = 2000, 30

#: Diagnostic code of errors in assets.
ASSET = "WMS210"

#: Numbers and paths in messages, which do not distinguish kinds of faults.
_NUMBERS = re.compile(r"`[^`]*[./][^`]*`|(?<![\w`])[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?", re.IGNORECASE)


@dataclass(frozen=True)
class Conditional:
    """An error that is irrelevant if the spec sets one of these properties of the link or the whole asset."""

    diagnostic: Diagnostic
    unless: tuple[str, ...]


def conditional(mistakes: Iterable[Diagnostic], unless: tuple[str, ...]) -> tuple[Conditional, ...]:
    """Return errors that the spec can override, with that remedy added."""
    return tuple(Conditional(replace(d, help=f"{d.help}, or say `{unless[0]}` in the spec"), unless) for d in mistakes)


class UnreadableAsset(Exception):
    """An asset that cannot be read further; the last error is the reason."""


@dataclass
class Faults:
    """Errors of one asset, and warnings about what is approximated or left out."""

    diagnostics: list[Diagnostic] = field(default_factory=list)
    warnings: list[Diagnostic] = field(default_factory=list)

    def add(self, where: FilePlace, message: str, help: str) -> None:
        """Add an error. Raises UnreadableAsset after the maximum number."""
        self.diagnostics.append(Diagnostic(message, where, help, ASSET))
        if len(self.diagnostics) >= MAX_FAULTS:
            raise UnreadableAsset

    def approximate(self, where: FilePlace, message: str, taken: str, help: str) -> None:
        """Add a warning: `taken` replaces a feature that is not supported."""
        text = f"{message}: {taken}" if taken else message
        if len(self.warnings) >= MAX_FAULTS:
            raise self.stop(where, f"has more than {MAX_FAULTS} faults", "is this the right file?")
        self.warnings.append(Diagnostic(text, where, help, APPROXIMATION, severity="warning"))

    def stop(self, where: FilePlace, message: str, help: str) -> UnreadableAsset:
        """Add a fatal error; raise what this returns."""
        self.diagnostics.append(Diagnostic(message, where, help, ASSET))
        return UnreadableAsset()

    @contextmanager
    def separately(self) -> Iterator[list[Diagnostic]]:
        """Collect the errors, then the warnings, of a `with` block separately."""
        outer = self.diagnostics, self.warnings
        self.diagnostics, self.warnings = [], []
        apart = list[Diagnostic]()
        try:
            yield apart
        finally:
            apart += [*self.diagnostics, *self.warnings]
            self.diagnostics, self.warnings = outer


def grouped(faults: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Return one diagnostic for each kind of fault, at its first place, with the number of places."""
    kinds: dict[tuple[str, str, str], list[Diagnostic]] = {}
    for fault in dict.fromkeys(faults):
        kinds.setdefault((fault.severity, _NUMBERS.sub("0", fault.message), fault.help), []).append(fault)
    made = [_counted(alike) for alike in kinds.values()]
    if len(made) > MAX_KINDS:
        more = f"{len(made) - MAX_KINDS} more kinds of faults"
        made = [*made[:MAX_KINDS], Diagnostic(more, made[MAX_KINDS].place, "", made[MAX_KINDS].code)]
    return tuple(made)


def _counted(alike: list[Diagnostic]) -> Diagnostic:
    first, count = alike[0], len(alike)
    return first if count == 1 else replace(first, message=f"{first.message} (here and {count - 1} more)")


@dataclass(frozen=True)
class Appearance:
    """Appearance of a shape: colour (sRGB), image (path relative to the spec's folder), roughness and metalness.

    None or '' means unset. The image is mapped once, or `repeats` times per metre. `conditional` holds unsupported
    features.
    """

    color: Color | None = None
    image: str = ""
    repeats: tuple[float, float] | None = None
    roughness: float | None = None
    metallic: float | None = None
    conditional: tuple[Conditional, ...] = ()


@dataclass(frozen=True)
class MeshFile:
    """A mesh file relative to the spec's folder, `scale` along each axis, and its `collision` mode.

    `corners` (m) of its box are known for a mesh of a stage.
    """

    file: str
    scale: tuple[float, ...] = (1.0, 1.0, 1.0)
    collision: str = "hull"
    corners: tuple[tuple[float, ...], ...] = ()


Form = Solid | MeshFile


@dataclass(frozen=True)
class Shape:
    """A geometry in its link's frame. Without `rubs` it has the link's friction and restitution."""

    form: Form
    pose: Pose
    look: Appearance = field(default_factory=Appearance)
    solid: bool = True
    drawn: bool = True
    friction_restitution: tuple[float, float] | None = None
    conditional: tuple[Conditional, ...] = ()


@dataclass(frozen=True)
class Link:
    """A rigid body; without shapes it is only a frame. `where` is its location in the file.

    A `massless` link has shapes and no mass of its own; another one without a mass has that of its density.
    `own_inertia` is that of the file if `mass` is a plausible one instead.

    `given` are scalars from the file: `density`, `friction`, `restitution`, `damping`. The initial `velocity` (3,) m/s
    and `spin` (3,) rad/s are in the asset's frame, the `surface_velocity` (3,) m/s of a belt is in its own. It does not
    collide with the links that it `passes`.
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
    massless: bool = False
    own_inertia: Inertia | None = None
    surface_velocity: tuple[float, float, float] | None = None


@dataclass(frozen=True)
class RejectedAsset:
    """Errors and warnings of an asset, plus links whose faults depend on overrides."""

    diagnostics: tuple[Diagnostic, ...]
    links: tuple[Link, ...]


@dataclass(frozen=True)
class Joint:
    """Connects `child` to `parent`. `place` is the child's frame in the parent's with the joint at 0.

    The joint is `at` (3,) along `axis` (3,) in the child's frame; ball and fixed joints ignore the axis. A `free` joint
    holds nothing. The default `start` is 0 or the nearest limit. The drive moves towards `target` at speed `pace`, with
    at most `strength`; SI units. `armature` is the inertia of a rotor, kg m² or kg.
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
    armature: float = 0.0


@dataclass(frozen=True)
class Asset:
    """Links and joints of a file by name, in file order."""

    links: dict[str, Link]
    joints: dict[str, Joint]
