"""What a backend is given (`Scene`) and what it gives back (`Trace`, `Frame`).

Units are SI, the world is Z up, quaternions are (w, x, y, z), colours are sRGB in 0..1. Everything is
immutable; arrays are float64 and never written to after construction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# ---------------------------------------------------------------- geometry


@dataclass(frozen=True)
class Pose:
    """A rigid placement: `position` (3,) in metres, `orientation` (4,) a unit quaternion (w, x, y, z)."""

    position: Array
    orientation: Array


@dataclass(frozen=True)
class Box:
    """An axis-aligned box with half-extents `half` (3,)."""

    half: Array


@dataclass(frozen=True)
class Sphere:
    """A sphere around the origin."""

    radius: float


@dataclass(frozen=True)
class Cylinder:
    """A cylinder along z, centred: its caps lie at ±height / 2."""

    radius: float
    height: float


@dataclass(frozen=True)
class Cone:
    """A cone along z, centred on half its height: base at -height / 2, apex at +height / 2."""

    radius: float
    height: float


@dataclass(frozen=True)
class Capsule:
    """A capsule along z, centred: `height` is the length of the straight part."""

    radius: float
    height: float


@dataclass(frozen=True)
class Mesh:
    """A triangle mesh: `points` (n, 3), `faces` (m, 3) vertex indices, `st` (n, 2) or None.

    Collides as its convex hull.
    """

    points: Array
    faces: NDArray[np.int32]
    st: Array | None = None


Shape = Box | Sphere | Cylinder | Cone | Capsule | Mesh


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


# ---------------------------------------------------------------- joints

JointKind = Literal["fixed", "hinge", "slider", "ball"]


@dataclass(frozen=True)
class Drive:
    """A damped spring along a joint's one coordinate: force `stiffness` (target - coordinate) + `damping` (velocity

    - rate of the coordinate), at most `max_force`. SI units: N/m and m of a slider, N m/rad and rad of a hinge.
    """

    stiffness: float
    damping: float
    target: float = 0.0
    velocity: float = 0.0
    max_force: float = float("inf")


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


# ---------------------------------------------------------------- actions


@dataclass(frozen=True)
class Launch:
    """At `start` (s) the dynamic body's velocity becomes `linear` (3,) m/s and `angular` (3,) rad/s."""

    name: str
    body: str
    start: float
    linear: Array
    angular: Array


@dataclass(frozen=True)
class Glide:
    """From `start` to `stop` (s) the kinematic body moves with constant `velocity` (3,) m/s."""

    name: str
    body: str
    start: float
    stop: float
    velocity: Array


@dataclass(frozen=True)
class Follow:
    """The kinematic body's frame is at `points[i]` (n, 3) m at `start + times[i]` (s), linear between them.

    `times` (n,) grow from 0. `orientations` (n, 4), or None to keep the one it has, turn by the shortest way.
    """

    name: str
    body: str
    start: float
    times: Array
    points: Array
    orientations: Array | None = None

    @property
    def stop(self) -> float:
        """When the way ends, s."""
        return self.start + float(self.times[-1])


@dataclass(frozen=True)
class Teleport:
    """At `start` (s) the kinematic body is placed at `pose`."""

    name: str
    body: str
    start: float
    pose: Pose


@dataclass(frozen=True)
class Impulse:
    """At `start` (s) the dynamic body is hit at its centre of mass with `impulse` (3,) N s, world axes."""

    name: str
    body: str
    start: float
    impulse: Array


@dataclass(frozen=True)
class Force:
    """From `start` to `stop` (s) the `force` (3,) N, world axes, acts at the centre of mass of the dynamic body."""

    name: str
    body: str
    start: float
    stop: float
    force: Array


@dataclass(frozen=True)
class Release:
    """The dynamic body, with all that is jointed to it, is held where it begins until `start` (s), then let go."""

    name: str
    body: str
    start: float


@dataclass(frozen=True)
class Steer:
    """From `start` (s) on the drive of the `joint` has this `target` (rad or m)."""

    name: str
    joint: str
    start: float
    target: float


Action = Launch | Glide | Follow | Teleport | Impulse | Force | Release | Steer

# ---------------------------------------------------------------- eyes


@dataclass(frozen=True)
class Camera:
    """A pinhole camera in USD's axes (looks along -z, +y up); `fovy` in radians, vertical.

    `pose` is in the frame of the `body` that it rides on, or in the world.
    """

    name: str
    pose: Pose
    fovy: float
    near: float
    far: float
    body: str | None = None


@dataclass(frozen=True)
class Light:
    """The sun: unit `direction` (3,) in which the light goes; `diffuse` + `ambient` = 1 lights a facing white fully."""

    direction: Array
    diffuse: float = 0.65
    ambient: float = 0.35


@dataclass(frozen=True)
class Observation:
    """The stage's own list of pictures to take: camera name and times (s)."""

    name: str
    camera: str
    times: tuple[float, ...]


@dataclass(frozen=True)
class Scene:
    """An episode, complete: everything that an engine needs to execute and draw it.

    `bodies` keep the stage's order, which is part of the result: engines are only bit-identical for a fixed order.
    `filtered`: pairs of names of bodies, each in the order of `bodies`, sorted, that pass through each other.
    """

    name: str
    gravity: Array
    bodies: tuple[Body, ...]
    actions: tuple[Action, ...]
    cameras: tuple[Camera, ...]
    light: Light
    background: tuple[float, float, float]
    observations: tuple[Observation, ...]
    duration: float
    rate: int = 240
    joints: tuple[Joint, ...] = ()
    filtered: tuple[tuple[str, str], ...] = ()


# ---------------------------------------------------------------- what comes back


@dataclass(frozen=True)
class Contact:
    """Two bodies (in scene order) touched from `start` to `stop` (s)."""

    first: str
    second: str
    start: float
    stop: float


@dataclass(frozen=True)
class Trace:
    """An executed episode: T samples of all N bodies (static ones included, in scene order), the first at time 0.

    `position` (T, N, 3) and `orientation` (T, N, 4) are of the body's frame; `linear_velocity` and
    `angular_velocity` (T, N, 3) of its centre of mass, in world axes.
    """

    engine: str
    bodies: tuple[str, ...]
    time: Array
    position: Array
    orientation: Array
    linear_velocity: Array
    angular_velocity: Array
    contacts: tuple[Contact, ...]

    def sample(self, time: float) -> int:
        """The index of the sample nearest to `time` (s)."""
        return int(np.abs(self.time - time).argmin())

    def poses(self, time: float) -> tuple[Pose, ...]:
        """The pose of every body at the sample nearest to `time` (s)."""
        i = self.sample(time)
        return tuple(Pose(p, q) for p, q in zip(self.position[i], self.orientation[i], strict=True))


@dataclass(frozen=True)
class Shot:
    """A picture asked for: which camera, and where every body of the scene is."""

    camera: str
    poses: Sequence[Pose]


@dataclass(frozen=True)
class Frame:
    """A picture: `rgb` (h, w, 3) uint8; `ids` (h, w) int16, the index of the body seen, -1 for the background;

    `depth` (h, w) float32 in metres along the view axis, 0 for the background, or None if it was not asked for.
    """

    rgb: NDArray[np.uint8]
    ids: NDArray[np.int16]
    depth: NDArray[np.float32] | None = field(default=None)


# ---------------------------------------------------------------- the shape of a backend

Look = Literal["parity", "beauty"]
"""The same picture from every engine, or the best that each can draw."""


class Renderer(Protocol):
    """Draws one scene, any number of times. Close it when done."""

    def draw(self, shot: Shot, *, depth: bool = False) -> Frame:
        """Draw a picture of the shot."""
        ...

    def repaint(self, scene: Scene) -> bool:
        """Draw `scene` from now on, which differs in colours only; False if that takes a new renderer."""
        ...

    def close(self) -> None:
        """Let go of everything."""
        ...


class Backend(Protocol):
    """What every package under `backends/` offers, by the same names."""

    name: str
    looks: tuple[Look, ...]

    def execute(self, scene: Scene) -> Trace:
        """Run the episode."""
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
