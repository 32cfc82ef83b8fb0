"""An episode in an engine's own steps, and the one loop that plays it in any engine.

Needs numpy only: the native scripts contain these definitions as they stand here. All numbers are plain floats, so
that the `repr` of an `Episode` is the Python text of it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from wmspec.sim.scene.model.transform import conjugate, multiply, rotate, turned, turning

Vector = tuple[float, ...]

TORN = 0.001  # m: a grip that is longer than this has torn
MEET, TOUCH = 0.0001, 0.002  # m: bodies touch from when they are less than the first apart until they are the second


@dataclass(frozen=True)
class Kick:
    """Before step number `step` the centre of mass of `body` gets these velocities, m/s and rad/s."""

    step: int
    body: int
    linear: Vector
    angular: Vector


@dataclass(frozen=True)
class Push:
    """In the steps `first` to `last` a force, N in world axes, acts at the centre of mass of `body`."""

    first: int
    last: int
    body: int
    force: Vector

    def during(self, step: int) -> Any:
        """The force (3,) in a step. What lasts has half of it at both ends: then engines' free motion is exact."""
        ends = self.first < self.last and step in (self.first, self.last)
        return np.array(self.force) * (0.5 if ends else self.first <= step <= self.last)


@dataclass(frozen=True)
class Drag:
    """Damping of a jointed body: force per speed, N s/m, torque per spin about its axes, N m s."""

    body: int
    linear: float
    angular: Vector


@dataclass(frozen=True)
class Hold:
    """From step number `first` until `until` the dynamic `body` stays where it began, or `at` another place (7,)."""

    until: int
    body: int
    first: int = 0
    at: Vector | None = None


@dataclass(frozen=True)
class Grip:
    """From step number `first` to `last` the kinematic body number `hand` holds the dynamic `body`.

    It holds it by `points` (m) of its own frame, wherever the body is then.
    """

    first: int
    last: int
    hand: int
    body: int
    points: tuple[Vector, ...]

    def anchors(self, hand: Any, body: Any) -> Any:
        """The points in the body's frame (n, 3), from where both are (7,)."""
        return rotate(conjugate(body[3:7]), hand[:3] + rotate(hand[3:7], np.array(self.points)) - body[:3])

    def stretch(self, hand: Any, body: Any, anchors: Any) -> Any:
        """How far apart (T,), m, the two (T, 13) are that should be together."""
        hand, body = hand[:, None], body[:, None]
        there = hand[..., :3] + rotate(hand[..., 3:7], np.array(self.points))
        return np.linalg.norm(there - body[..., :3] - rotate(body[..., 3:7], anchors), axis=2).max(axis=1)


@dataclass(frozen=True)
class Aim:
    """Before step number `step` the drive of the joint number `joint` gets this target, rad or m."""

    step: int
    joint: int
    target: float


@dataclass(frozen=True)
class Track:
    """The path of a kinematic body, which may jump between its parts: from `times[i]` (s) on it moves from `points[i]`
    with `velocities[i]`, and turns from `turns[i]`, quaternions, with `spins[i]`, rad/s.
    """

    body: int
    times: Vector
    points: tuple[Vector, ...]
    velocities: tuple[Vector, ...]
    turns: tuple[Vector, ...]
    spins: tuple[Vector, ...]

    def at(self, times: Any) -> Any:
        """Position, quaternion, linear and angular velocity, (T, 13), from each of the `times` (T,) on."""
        return self.parts(np.searchsorted(self.times, times, side="right") - 1, times)

    def parts(self, which: Any, times: Any) -> Any:
        """The same, on the given parts of the path (T,)."""
        velocities, spins = np.array(self.velocities)[which], np.array(self.spins)[which]
        since = (times - np.array(self.times)[which])[:, None]
        turns = multiply(turning(since * spins), np.array(self.turns)[which])
        return np.concatenate([np.array(self.points)[which] + since * velocities, turns, velocities, spins], axis=1)

    def steps(self, times: Any) -> tuple[Any, Any, Any]:
        """Between the `times` (T,): where each step begins and ends (T - 1, 7), and its velocities (T - 1, 6)."""
        begun, ended = (np.searchsorted(self.times, times, side=side) - 1 for side in ("right", "left"))
        poses = self.parts(begun, times)[:, :7]
        here, there = poses[:-1], poses[1:].copy()
        ends = 1 + np.flatnonzero(begun[1:] != ended[1:])  # it may jump there
        there[ends - 1] = self.parts(ended[ends], times[ends])[:, :7]
        turn = turned(multiply(there[:, 3:], conjugate(here[:, 3:])))
        return here, there, np.concatenate([there[:, :3] - here[:, :3], turn], axis=1) / np.diff(times)[:, None]


@dataclass(frozen=True)
class Episode:
    """Samples at `rate` (Hz), `substeps` engine steps between them; poses are position and quaternion (w, x, y, z).

    What is `unfelt` has no shape that could be touched, so that nobody needs to be told how it moves.

    `start` is where each body's centre-of-mass frame is, `mounts` where the body's own frame is inside that one.
    """

    rate: int
    substeps: int
    samples: int
    gravity: Vector
    start: tuple[Vector, ...]
    mounts: tuple[Vector, ...]
    dynamic: tuple[int, ...]
    kicks: tuple[Kick, ...]
    tracks: tuple[Track, ...]
    pushes: tuple[Push, ...] = ()
    holds: tuple[Hold, ...] = ()
    aims: tuple[Aim, ...] = ()
    drags: tuple[Drag, ...] = ()
    grips: tuple[Grip, ...] = ()
    unfelt: tuple[int, ...] = ()

    @property
    def step(self) -> float:
        """The engine's time step, s."""
        return 1 / (self.rate * self.substeps)


@dataclass(frozen=True)
class Recording:
    """`states` (T, N, 13): pose of the body's frame, linear and angular velocity of its centre of mass, world axes.

    `touching`: for each engine step the pairs of bodies that touch. They do until they are `TOUCH` apart, because what
    slides fast hops by up to 1.6 mm in some engines. `torn`: when (s) which grip was first stretched, by how much (m).
    """

    states: Any
    touching: list[set[tuple[int, int]]]
    torn: tuple[tuple[float, int, float], ...] = ()


class World(Protocol):
    """What an engine must be able to do, for bodies by their number and in their centre-of-mass frames."""

    def kick(self, body: int, linear: Any, angular: Any) -> None:
        """Set the velocities of a dynamic body."""

    def driven(self, paths: Mapping[int, tuple[Any, Any, Any]]) -> Callable[[int], None]:
        """What makes kinematic bodies move in step number i, before which it is called with i.

        Each from where it is then, (T, 7), to where it is after the step, with velocities (T, 6).
        """

    def push(self, body: int, force: Any, torque: Any) -> None:
        """Let a force and a torque (3,) act at the centre of mass of a dynamic body during the next step."""

    def hold(self, body: int, at: Any = None) -> None:
        """Put a dynamic body, with all that is jointed to it, back where it began, at rest, and let nothing move it.

        With a pose `at` (7,), put the body, which has no joints, there instead.
        """

    def free(self, body: int) -> None:
        """Let go of what has been held."""

    def aim(self, joint: int, target: float) -> None:
        """Give the drive of a joint this target."""

    def grip(self, number: int, grip: Grip, anchors: Any) -> None:
        """Tie the points of the grip with this number to the `anchors` (n, 3) in the frame of its body."""

    def loose(self, number: int, grip: Grip) -> None:
        """Let go of it."""

    def step(self) -> None:
        """Advance by one time step."""

    def state(self, body: int) -> Sequence[float]:
        """Position (3), quaternion (4), linear (3) and angular velocity (3) of a dynamic body."""

    def touching(self) -> set[tuple[int, int]]:
        """The pairs of bodies, lower number first, that touched in the last step, by `MEET` and `TOUCH`."""


def play(world: World, episode: Episode) -> Recording:
    """Play the episode in a freshly built world."""
    if (recording := told(episode)) is not None:
        return recording
    steps, states = (episode.samples - 1) * episode.substeps, expected(episode)
    needed = {track.body for track in episode.tracks}.difference(episode.unfelt)
    needed |= {grip.hand for grip in episode.grips}
    times = np.arange(steps + 1) * episode.step
    paths = {track.body: track.steps(times) for track in episode.tracks if track.body in needed}
    begins = beginnings(episode)
    drive = world.driven({body: path for body, path in paths.items() if body not in episode.unfelt})
    held: dict[int, Any] = {}
    touching = []
    for i in range(steps + 1):
        kicks = begin(world, episode, i) if i in begins else []
        if i in begins:
            take(world, episode, paths, held, i)
        if i % episode.substeps == 0:
            observe(world, episode, kicks, states[i // episode.substeps])
        if i == steps:
            break
        drive(i)
        act(world, episode, i)
        world.step()
        touching.append(world.touching())
    return Recording(mounted(states, episode), touching, torn(episode, held, states))


def told(episode: Episode) -> Recording | None:
    """What is recorded where nothing is left to compute; None where an engine must play the episode.

    What moves as it is told never touches what does too, and in a single sample nothing moves.
    """
    steps = (episode.samples - 1) * episode.substeps
    free = {kick.body for kick in episode.kicks}  # of what joints hold, engines know the velocities
    if episode.dynamic and (steps or not free.issuperset(episode.dynamic)):
        return None
    states = expected(episode)
    for kick in episode.kicks:
        if kick.step == 0:
            states[0, kick.body, 7:] = kick.linear + kick.angular
    return Recording(mounted(states, episode), [set()] * steps)


def expected(episode: Episode) -> Any:
    """The states (T, N, 13) of bodies that stand where they begin or move along their tracks."""
    states = np.zeros((episode.samples, len(episode.start), 13))
    states[:, :, :7] = episode.start
    for track in episode.tracks:
        states[:, track.body] = track.at(np.arange(episode.samples) / episode.rate)
    return states


def beginnings(episode: Episode) -> set[int]:
    """The numbers of the steps before which something happens at once."""
    held = (i for hold in episode.holds for i in range(hold.first, hold.until + 1))
    taken = {step for grip in episode.grips for step in (grip.first, grip.last)}
    return {*held, *taken, *(kick.step for kick in episode.kicks), *(aim.step for aim in episode.aims)}


def begin(world: World, episode: Episode, i: int) -> list[Kick]:
    """What happens at once before step number `i`; the kicks, as they are to be recorded."""
    for hold in episode.holds:
        if hold.first <= i < hold.until:
            world.hold(hold.body, hold.at)
        elif i == hold.until:
            world.free(hold.body)
    for aim in episode.aims:
        if aim.step == i:
            world.aim(aim.joint, aim.target)
    kicks = [kick for kick in episode.kicks if kick.step == i]
    for kick in kicks:  # engines fall by g h² too much in the first step; half a step less of g makes flight exact
        half_fall = np.array(episode.gravity) * (episode.step / 2)
        world.kick(kick.body, np.array(kick.linear) - half_fall, np.array(kick.angular))
    return kicks


def take(world: World, episode: Episode, paths: Any, held: dict[int, Any], i: int) -> None:
    """Let hands take and let go before step number `i`; `held` gets the anchors of what is taken, by number of grip."""
    for number, grip in enumerate(episode.grips):
        if i == grip.last and number in held:
            world.loose(number, grip)
        if grip.first <= i < grip.last and i == grip.first:
            hand = paths[grip.hand][0][i] if i < len(paths[grip.hand][0]) else paths[grip.hand][1][-1]
            held[number] = grip.anchors(hand, np.asarray(world.state(grip.body)))
            world.grip(number, grip, held[number])


def torn(episode: Episode, held: dict[int, Any], states: Any) -> tuple[tuple[float, int, float], ...]:
    """The grips that grew longer than `TORN`, in order: when (s), the number, and how long (m); `states` (T, N, 13)."""
    found = []
    for number, anchors in held.items():
        grip = episode.grips[number]
        first, last = (-(-step // episode.substeps) for step in (grip.first, grip.last))
        lengths = grip.stretch(states[first:last, grip.hand], states[first:last, grip.body], anchors)
        over = np.flatnonzero(lengths > TORN)
        if len(over):
            found.append(((first + int(over[0])) * episode.substeps * episode.step, number, float(lengths[over[0]])))
    return tuple(sorted(found))


def act(world: World, episode: Episode, i: int) -> None:
    """What pushes during step number `i`."""
    for push in episode.pushes:
        if push.first <= i <= push.last:
            world.push(push.body, push.during(i), np.zeros(3))
    for drag in episode.drags:
        state = np.asarray(world.state(drag.body))
        turn, speed, spin = state[3:7], state[7:10], state[10:]
        torque = rotate(turn, np.array(drag.angular) * rotate(conjugate(turn), spin))
        world.push(drag.body, -drag.linear * speed, -torque)


def observe(world: World, episode: Episode, kicks: list[Kick], into: Any) -> None:
    """Write the state of every dynamic body into `into` (N, 13)."""
    for body in episode.dynamic:
        into[body] = world.state(body)
    for kick in kicks:
        into[kick.body, 7:] = kick.linear + kick.angular


def mounted(states: Any, episode: Episode) -> Any:
    """The states (T, N, 13) with poses of the bodies' own frames in place of those of their centres of mass."""
    mounts = np.array(episode.mounts)
    turns = states[..., 3:7] / np.linalg.norm(states[..., 3:7], axis=-1, keepdims=True)
    positions = states[..., :3] + rotate(turns, mounts[:, :3])
    return np.concatenate([positions, multiply(turns, mounts[:, 3:]), states[..., 7:]], axis=-1)
