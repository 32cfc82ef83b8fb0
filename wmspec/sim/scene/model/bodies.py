"""Bodies, their geoms and materials, and the joints between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from wmspec.sim.scene.model.geometry import Array, Pose
from wmspec.sim.shapes import Shape


@dataclass(frozen=True)
class Surface:
    """The appearance of a geom, as in UsdPreviewSurface. The image `texture` is multiplied by the colour.

    Without `repeats` the texture coordinates of the shape apply. With `repeats` (s and t) the image repeats per metre
    of the shape, or per unit of the texture coordinates of a mesh.
    """

    color: tuple[float, float, float] = (0.5, 0.5, 0.5)
    roughness: float = 0.6
    metallic: float = 0.0
    texture: str | None = None
    repeats: tuple[float, float] | None = None


@dataclass(frozen=True)
class Friction:
    """Physics material. A pair has the geometric mean of the friction and restitution of both sides."""

    static: float = 0.5
    dynamic: float = 0.5
    restitution: float = 0.0


@dataclass(frozen=True)
class Geom:
    """One shape of a body, placed in the body frame: drawn if `visible`, collides if `collides`."""

    name: str
    shape: Shape
    pose: Pose
    surface: Surface = Surface()
    friction: Friction = Friction()
    collides: bool = True
    visible: bool = True


@dataclass(frozen=True)
class Inertia:
    """Mass (kg); centre of mass (3,) and principal axes (4,) in the body frame; moments (3,) in kg m²."""

    mass: float
    center: Array
    axes: Array
    moments: Array


Motion = Literal["static", "dynamic", "kinematic"]


@dataclass(frozen=True)
class Body:
    """A rigid body. `name` is unique in the scene, `path` is its prim.

    `inertia` is None unless the body is dynamic. A kinematic body follows the actions of the scene and rests otherwise.
    Velocities (3,) are in world axes at the centre of mass. A belt is a kinematic body whose surface moves at
    `surface_velocity` (m/s, along the axes of the body) and carries along what touches it, while the body stays.
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
    surface_velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def mass(self) -> float:
        """Mass (kg), 0 unless the body is dynamic."""
        return float(self.inertia.mass) if self.inertia is not None else 0.0


JointKind = Literal["fixed", "hinge", "slider", "ball"]


@dataclass(frozen=True)
class Drive:
    """A damped spring along the single coordinate of a joint.

    Its force is `stiffness` * (target - coordinate) + `damping` * (velocity - rate), at most `max_force`. SI units: N/m
    and m of a slider, N m/rad and rad of a hinge. A `weightless` drive prescribes acceleration;
    `wmspec.sim.scene.joints.drives.with_force_drives` converts it before an engine receives it.
    """

    stiffness: float
    damping: float
    target: float = 0.0
    velocity: float = 0.0
    max_force: float = float("inf")
    weightless: bool = False


@dataclass(frozen=True)
class Mimic:
    """Couples a joint to joint `leader`: coordinate = `ratio` * leader + `offset`, rad and m."""

    leader: str
    ratio: float
    offset: float = 0.0


@dataclass(frozen=True)
class Joint:
    """Connects body `second` to `first` (None for the world) by a frame in each of them.

    The coordinate is the pose of the second frame in the first: the angle about the common x axis (rad) of a hinge, the
    distance along it (m) of a slider. `limits`: lowest and highest value. The frames of a ball joint share their
    origin, those of a fixed joint coincide. `collides`: whether the two bodies collide with each other. `armature`:
    inertia of a rotor that only the coordinate of a hinge (kg m²) or slider (kg) moves.
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
    armature: float = 0.0
