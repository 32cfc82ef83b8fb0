"""Bodies, what they are made of and look like, and the joints between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from wmspec.sim.scene.model.geometry import Array, Pose
from wmspec.sim.shapes import Shape


@dataclass(frozen=True)
class Surface:
    """How a geometry looks: a UsdPreviewSurface. The image at the path `texture` is multiplied by the colour.

    Without `repeats` the image is laid out as the shape's texture coordinates say; with it, it is repeated so often (in
    s and t) on a metre of the shape, or on a unit of a mesh's own texture coordinates if it has any.
    """

    color: tuple[float, float, float] = (0.5, 0.5, 0.5)
    roughness: float = 0.6
    metallic: float = 0.0
    texture: str | None = None
    repeats: tuple[float, float] | None = None


@dataclass(frozen=True)
class Friction:
    """Physics material. A touching pair has the geometric mean of both sides' friction and restitution."""

    static: float = 0.5
    dynamic: float = 0.5
    restitution: float = 0.0


@dataclass(frozen=True)
class Geom:
    """One piece of a body, placed in the body's frame: drawn if `visible`, touched if `collides`."""

    name: str
    shape: Shape
    pose: Pose
    surface: Surface = Surface()
    friction: Friction = Friction()
    collides: bool = True
    visible: bool = True


@dataclass(frozen=True)
class Inertia:
    """Mass (kg); centre of mass (3,) and principal axes (4,) in the body's frame; moments (3,) in kg m²."""

    mass: float
    center: Array
    axes: Array
    moments: Array


Motion = Literal["static", "dynamic", "kinematic"]


@dataclass(frozen=True)
class Body:
    """A rigid body. `name` is unique in the scene, `path` is its prim.

    `inertia` is None unless the body is dynamic. A kinematic body moves as the scene's actions say
    and stands still otherwise. Velocities (3,) are in world axes, at the centre of mass.
    """

    name: str
    path: str
    motion: Motion
    pose: Pose
    geoms: tuple[Geom, ...]
    inertia: Inertia | None
    linear_velocity: Array
    angular_velocity: Array
    linear_damping: float = 0.0
    angular_damping: float = 0.0

    @property
    def mass(self) -> float:
        """Its mass (kg), 0 unless it is dynamic."""
        return float(self.inertia.mass) if self.inertia is not None else 0.0


JointKind = Literal["fixed", "hinge", "slider", "ball"]


@dataclass(frozen=True)
class Drive:
    """A damped spring along a joint's one coordinate.

    Its force is `stiffness` (target - coordinate) + `damping` (velocity - rate of the coordinate), at most `max_force`.
    SI units: N/m and m of a slider, N m/rad and rad of a hinge. What is `weightless` is so for each unit of what it
    moves; no engine is given that, see `wmspec.sim.scene.joints.drives.weighed`.
    """

    stiffness: float
    damping: float
    target: float = 0.0
    velocity: float = 0.0
    max_force: float = float("inf")
    weightless: bool = False


@dataclass(frozen=True)
class Mimic:
    """A joint's coordinate is `ratio` times that of the joint named `leader`, and `offset`; rad and m."""

    leader: str
    ratio: float
    offset: float = 0.0


@dataclass(frozen=True)
class Joint:
    """Holds `second` to `first`, names of bodies (`first` may be None: the world), by a frame in each of them.

    The coordinate is where the second frame is seen from the first: the angle about the common x axis (rad) of a hinge,
    the way along it (m) of a slider. `limits`: its least and greatest value. The frames of a ball joint share their
    origin, those of a fixed one are the same. `collides`: whether the two bodies can touch each other.
    """

    name: str
    path: str
    kind: JointKind
    first: str | None
    second: str
    first_frame: Pose
    second_frame: Pose
    limits: tuple[float, float] | None = None
    drive: Drive | None = None
    collides: bool = False
    mimic: Mimic | None = None
