"""Actions on bodies and drives."""

from __future__ import annotations

from dataclasses import dataclass

from wmspec.sim.scene.model.geometry import Array


@dataclass(frozen=True)
class _OnBody:
    """An action on `body`, from `start` (s) on."""

    name: str
    body: str
    start: float


@dataclass(frozen=True)
class Launch(_OnBody):
    """Sets the velocity of a dynamic body to `linear` (3,) m/s and `angular` (3,) rad/s at `start` (s)."""

    linear: Array
    angular: Array


@dataclass(frozen=True)
class Glide(_OnBody):
    """Moves a kinematic body with constant `velocity` (3,) m/s from `start` to `stop` (s)."""

    stop: float
    velocity: Array


@dataclass(frozen=True)
class Follow(_OnBody):
    """Moves a kinematic body through `points[i]` (n, 3) m at `start + times[i]` (s), linear between them.

    `times` (n,) increase from 0. `orientations` (n, 4) are interpolated the shortest way; None keeps the orientation.
    """

    times: Array
    points: Array
    orientations: Array | None = None

    @property
    def stop(self) -> float:
        """End of the path, s."""
        return self.start + float(self.times[-1])


@dataclass(frozen=True)
class Teleport(_OnBody):
    """Places a body at `position` (3,) m at `start` (s); a dynamic one keeps its velocities.

    `orientation` (4,): None keeps the one it has.
    """

    position: Array
    orientation: Array | None = None


@dataclass(frozen=True)
class Impulse(_OnBody):
    """Applies `impulse` (3,) N s, world axes, at the centre of mass of a dynamic body at `start` (s)."""

    impulse: Array


@dataclass(frozen=True)
class Force(_OnBody):
    """Applies `force` (3,) N, world axes, at the centre of mass of a dynamic body from `start` to `stop` (s)."""

    stop: float
    force: Array


@dataclass(frozen=True)
class Release(_OnBody):
    """Holds a dynamic body and all bodies jointed to it at their start until `start` (s)."""


@dataclass(frozen=True)
class Steer:
    """Sets the `target` (rad or m) of the drive of a joint at `start` (s)."""

    name: str
    joint: str
    start: float
    target: float


@dataclass(frozen=True)
class Grip:
    """Ties the dynamic `body` to the kinematic `hand` by `points` (n, 3) m of the hand's frame, `start` to `stop` (s).

    The relative pose at `start` is kept. One point acts as a ball joint, two as a hinge, three fix the body.
    """

    name: str
    body: str
    hand: str
    start: float
    stop: float
    points: Array


@dataclass(frozen=True)
class Paint(_OnBody):
    """Sets the `color` of all of a body, sRGB in 0..1, from `start` (s) on."""

    color: tuple[float, float, float]


@dataclass(frozen=True)
class Vanish(_OnBody):
    """Removes a non-static body without joints from `start` (s) on: it neither collides nor is visible."""


@dataclass(frozen=True)
class PassThrough:
    """Lets `body` go through the body `through`: the two do not collide from `start` to `stop` (s)."""

    name: str
    body: str
    through: str
    start: float
    stop: float


Action = Launch | Glide | Follow | Teleport | Impulse | Force | Release | Steer | Grip | Paint | Vanish | PassThrough
