"""What is done to bodies and drives."""

from __future__ import annotations

from dataclasses import dataclass

from wmspec.sim.scene.model.geometry import Array, Pose


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


@dataclass(frozen=True)
class Grip:
    """From `start` to `stop` (s) the kinematic body `hand` holds the dynamic `body` by `points` (n, 3) m of its frame.

    The place of the body in the hand is the one that it has at `start`. One point is a ball joint, two a hinge, three
    hold it fast.
    """

    name: str
    body: str
    hand: str
    start: float
    stop: float
    points: Array


@dataclass(frozen=True)
class Paint:
    """From `start` (s) on all of the body has this `color`, sRGB in 0..1, whatever moves it."""

    name: str
    body: str
    start: float
    color: tuple[float, float, float]


@dataclass(frozen=True)
class Vanish:
    """From `start` (s) on the body, which can move and has no joints, is nowhere: nothing touches or shows it."""

    name: str
    body: str
    start: float


Action = Launch | Glide | Follow | Teleport | Impulse | Force | Release | Steer | Grip | Paint | Vanish
