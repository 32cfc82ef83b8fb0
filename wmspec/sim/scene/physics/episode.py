"""An episode in engine steps, and the loop that executes it in every engine.

Imports numpy only: native scripts contain a copy of these definitions. All numbers are plain floats, so that the
`repr` of an `Episode` is valid Python.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Protocol

import numpy as np

from wmspec.sim.scene.model.transform import conjugate, from_rotation_vector, multiply, rotate, to_rotation_vector

Vector = tuple[float, ...]

BREAK_LENGTH = 0.001  # m: a longer grip counts as broken
TOUCH_BEGIN, TOUCH_END = 0.0001, 0.002  # m: distances at which a contact begins and ends


@dataclass(frozen=True)
class Kick:
    """Velocities of the centre of mass of `body` set before step number `step`, m/s and rad/s."""

    step: int
    body: int
    linear: Vector
    angular: Vector


@dataclass(frozen=True)
class Push:
    """A force (N, world axes) at the centre of mass of `body` during the steps `first` to `last`."""

    first: int
    last: int
    body: int
    force: Vector

    def during(self, step: int) -> Any:
        """Return the force (3,) in a step; the first and the last step get half, which makes free motion exact."""
        ends = self.first < self.last and step in (self.first, self.last)
        return np.array(self.force) * (0.5 if ends else self.first <= step <= self.last)


@dataclass(frozen=True)
class Drag:
    """Damping of a jointed body: force per velocity (N s/m), torque per angular velocity about its axes (N m s)."""

    body: int
    linear: float
    angular: Vector


@dataclass(frozen=True)
class Hold:
    """Keeps the dynamic `body` at its start, or at the pose `at` (7,), from step `first` until `until`."""

    until: int
    body: int
    first: int = 0
    at: Vector | None = None


@dataclass(frozen=True)
class Jump:
    """Places the frame of the dynamic `body` at `position` before step number `step`; it keeps its velocities.

    Without an `orientation` it keeps that too.
    """

    step: int
    body: int
    position: Vector
    orientation: Vector | None = None

    def landing(self, mount: Any, state: Any) -> Any:
        """Return the new pose (7,) of the centre of mass, given its `state` (13,) and the body frame in it (7,)."""
        turn = state[3:7]
        if self.orientation is not None:
            turn = multiply(np.array(self.orientation), conjugate(mount[3:]))
        return np.concatenate([np.array(self.position) - rotate(turn, mount[:3]), turn])


@dataclass(frozen=True)
class Grip:
    """Ties the dynamic `body` to the kinematic body `hand` from step `first` to `last`.

    `points` (m) are in the frame of the hand.
    """

    first: int
    last: int
    hand: int
    body: int
    points: tuple[Vector, ...]

    def anchors(self, hand: Any, body: Any) -> Any:
        """Return the points in the frame of the body (n, 3), given both poses (7,)."""
        return rotate(conjugate(body[3:7]), hand[:3] + rotate(hand[3:7], np.array(self.points)) - body[:3])

    def stretch(self, hand: Any, body: Any, anchors: Any) -> Any:
        """Return the distance (T,), m, between the tied points of two states (T, 13)."""
        hand, body = hand[:, None], body[:, None]
        there = hand[..., :3] + rotate(hand[..., 3:7], np.array(self.points))
        return np.linalg.norm(there - body[..., :3] - rotate(body[..., 3:7], anchors), axis=2).max(axis=1)


@dataclass(frozen=True)
class Passage:
    """The bodies `body` and `through` do not collide from step `first` until `last`."""

    first: int
    last: int
    body: int
    through: int


@dataclass(frozen=True)
class Aim:
    """Target (rad or m) of the drive of joint number `joint`, set before step number `step`."""

    step: int
    joint: int
    target: float


@dataclass(frozen=True)
class KinematicPath:
    """The path of a kinematic body in pieces of constant velocity; it may jump between pieces.

    From `times[i]` (s) on it moves from `points[i]` (m) with `velocities[i]` (m/s) and rotates from the quaternion
    `turns[i]` with `spins[i]` (rad/s).

    In every step it also moves with the velocity of its `surface` (m/s, its own axes), and is back where it was before
    the next step. Engines then see a surface that moves and a body that stays.
    """

    body: int
    times: Vector
    points: tuple[Vector, ...]
    velocities: tuple[Vector, ...]
    turns: tuple[Vector, ...]
    spins: tuple[Vector, ...]
    surface: Vector = (0.0, 0.0, 0.0)

    def at(self, times: Any) -> Any:
        """Return position, quaternion, linear and angular velocity (T, 13) at `times` (T,)."""
        return self.parts(np.searchsorted(self.times, times, side="right") - 1, times)

    def parts(self, which: Any, times: Any) -> Any:
        """Return the same for given pieces of the path (T,)."""
        velocities, spins = np.array(self.velocities)[which], np.array(self.spins)[which]
        since = (times - np.array(self.times)[which])[:, None]
        turns = multiply(from_rotation_vector(since * spins), np.array(self.turns)[which])
        return np.concatenate([np.array(self.points)[which] + since * velocities, turns, velocities, spins], axis=1)

    def steps(self, times: Any) -> tuple[Any, Any, Any]:
        """Return start and end poses (T - 1, 7) and velocities (T - 1, 6) of the steps between `times` (T,)."""
        begun, ended = (np.searchsorted(self.times, times, side=side) - 1 for side in ("right", "left"))
        poses = self.parts(begun, times)[:, :7]
        here, there = poses[:-1], poses[1:].copy()
        ends = 1 + np.flatnonzero(begun[1:] != ended[1:])  # the path may jump here
        there[ends - 1] = self.parts(ended[ends], times[ends])[:, :7]
        if any(self.surface):
            there[:, :3] += rotate(here[:, 3:], np.array(self.surface)) * np.diff(times)[:, None]
        turn = to_rotation_vector(multiply(there[:, 3:], conjugate(here[:, 3:])))
        return here, there, np.concatenate([there[:, :3] - here[:, :3], turn], axis=1) / np.diff(times)[:, None]


@dataclass(frozen=True)
class Episode:
    """All events of an execution: `rate` samples a second with `substeps` engine steps between samples.

    Poses are position and quaternion (w, x, y, z). `start` holds the centre-of-mass frame of each body, `mounts` the
    body frame relative to it. Bodies in `untouchable` have no colliding geom; engines need not move them.
    """

    rate: int
    substeps: int
    samples: int
    gravity: Vector
    start: tuple[Vector, ...]
    mounts: tuple[Vector, ...]
    dynamic: tuple[int, ...]
    kicks: tuple[Kick, ...]
    tracks: tuple[KinematicPath, ...]
    pushes: tuple[Push, ...] = ()
    holds: tuple[Hold, ...] = ()
    aims: tuple[Aim, ...] = ()
    drags: tuple[Drag, ...] = ()
    grips: tuple[Grip, ...] = ()
    untouchable: tuple[int, ...] = ()
    passages: tuple[Passage, ...] = ()
    jumps: tuple[Jump, ...] = ()

    @property
    def step(self) -> float:
        """Time step of the engine, s."""
        return 1 / (self.rate * self.substeps)


@dataclass(frozen=True)
class Recording:
    """What an engine recorded.

    `states` (T, N, 13): pose of the body frame, linear and angular velocity of the centre of mass, world axes.
    `touching`: the touching pairs in each engine step. A contact ends at distance `TOUCH_END`, because fast sliding
    bodies hop by up to 1.6 mm in some engines. `broken_grips`: time (s), number and length (m) of each broken grip.
    """

    states: Any
    touching: list[set[tuple[int, int]]]
    broken_grips: tuple[tuple[float, int, float], ...] = ()


class World(Protocol):
    """The operations that an engine implements, for numbered bodies in their centre-of-mass frames."""

    def kick(self, body: int, linear: Any, angular: Any, at: Any = None) -> None:
        """Set the velocities of a dynamic body, and its pose if `at` (7,) is given."""

    def driven(self, paths: Mapping[int, tuple[Any, Any, Any]]) -> Callable[[int], None]:
        """Return a function that moves the kinematic bodies in step i; it is called before that step.

        `paths` holds the pose before (T, 7) and after (T, 7) each step and the velocities (T, 6).
        """

    def push(self, body: int, force: Any, torque: Any) -> None:
        """Apply a force and a torque (3,) at the centre of mass of a dynamic body during the next step."""

    def hold(self, body: int, at: Any = None) -> None:
        """Reset a dynamic body and its joint tree to the start, at rest, and keep it there.

        With a pose `at` (7,), keep the body (without joints) there instead.
        """

    def free(self, body: int) -> None:
        """Release a held body."""

    def aim(self, joint: int, target: float) -> None:
        """Set the target of the drive of a joint."""

    def collide(self, one: int, other: int, collides: bool) -> None:
        """Set whether two bodies collide, from the next step on."""

    def grip(self, number: int, grip: Grip, anchors: Any) -> None:
        """Tie the points of grip `number` to the `anchors` (n, 3) in the frame of its body."""

    def loose(self, number: int, grip: Grip) -> None:
        """Release grip `number`."""

    def leave_out(self, first: int, most: int) -> int:
        """Leave out steps from `first` on that change nothing, at most `most`; return their number."""

    def step(self) -> None:
        """Advance by one time step."""

    def state(self, body: int) -> Sequence[float]:
        """Return position (3), quaternion (4), linear (3) and angular velocity (3) of a dynamic body."""

    def touching(self) -> set[tuple[int, int]]:
        """Return the pairs of bodies, lower number first, that touched in the last step."""


def play(world: World, episode: Episode) -> Recording:
    """Execute the episode in a new world."""
    (recording,) = play_together([world], [episode], world.step)
    return recording


def play_together(worlds: Sequence[World], episodes: Sequence[Episode], step: Callable[[], None]) -> list[Recording]:
    """Execute each episode in its new world; `step` advances all worlds, those of finished episodes too."""
    running = {i: perform(*both) for i, both in enumerate(zip(worlds, episodes, strict=True))}
    recordings: dict[int, Recording] = {}
    while True:
        for i, one in list(running.items()):
            try:
                next(one)
            except StopIteration as end:
                recordings[i] = end.value
                del running[i]
        if not running:
            return [recordings[i] for i in range(len(worlds))]
        step()


def perform(world: World, episode: Episode) -> Generator[None, None, Recording]:
    """Execute the episode in a new world; yield where the world is to make a step, and return the recording."""
    if (recording := kinematic_recording(episode)) is not None:
        return recording
    steps, states = (episode.samples - 1) * episode.substeps, scripted_states(episode)
    needed = {track.body for track in episode.tracks}.difference(episode.untouchable)
    needed |= {grip.hand for grip in episode.grips}
    paths = {track.body: path_steps(track, steps, episode.step) for track in episode.tracks if track.body in needed}
    begins, quiet = event_steps(episode), quiet_steps(episode)
    drive = world.driven({body: path for body, path in paths.items() if body not in episode.untouchable})
    held: dict[int, Any] = {}
    touching: list[set[tuple[int, int]]] = []
    i = 0
    while True:
        kicks = apply_events(world, episode, i) if i in begins else []
        if i in begins:
            apply_grips(world, episode, paths, held, i)
        if i % episode.substeps == 0:
            record_state(world, episode, kicks, states[i // episode.substeps])
        if i == steps:
            break
        if left_out := world.leave_out(i, quiet[i]):
            for sample in range(i // episode.substeps + 1, -(-(i + left_out) // episode.substeps)):
                record_state(world, episode, [], states[sample])
            touching += touching[-1:] * left_out
            i += left_out
            continue
        drive(i)
        apply_forces(world, episode, i)
        yield
        touching.append(world.touching())
        i += 1
    return Recording(to_body_frames(states, episode), touching, broken_grips(episode, held, states))


@lru_cache(24)
def path_steps(path: KinematicPath, steps: int, step: float) -> tuple[Any, Any, Any]:
    """Return `path.steps` of `steps` time steps of `step` (s) each, as arrays that cannot be written to.

    Nudged episodes, and engines with the same time step, move kinematic bodies alike.
    """
    arrays = path.steps(np.arange(steps + 1) * step)
    for array in arrays:
        array.flags.writeable = False
    return arrays


def kinematic_recording(episode: Episode) -> Recording | None:
    """Return the recording of an episode that needs no engine, or None.

    Kinematic bodies never collide with each other, and an episode of one sample has no motion.
    """
    steps = (episode.samples - 1) * episode.substeps
    free = {kick.body for kick in episode.kicks}  # only engines know the velocities of jointed bodies
    if episode.dynamic and (steps or episode.jumps or not free.issuperset(episode.dynamic)):
        return None
    states = scripted_states(episode)
    for kick in episode.kicks:
        if kick.step == 0:
            states[0, kick.body, 7:] = kick.linear + kick.angular
    return Recording(to_body_frames(states, episode), [set()] * steps)


def scripted_states(episode: Episode) -> Any:
    """Return the states (T, N, 13) of bodies that rest at their start or follow their tracks."""
    states = np.zeros((episode.samples, len(episode.start), 13))
    states[:, :, :7] = episode.start
    for track in episode.tracks:
        states[:, track.body] = track.at(np.arange(episode.samples) / episode.rate)
    return states


def event_steps(episode: Episode) -> set[int]:
    """Return the numbers of the steps that are preceded by an event."""
    held = (i for hold in episode.holds for i in range(hold.first, hold.until + 1))
    taken = {step for grip in episode.grips for step in (grip.first, grip.last)}
    open_ = (step for passage in episode.passages for step in (passage.first, passage.last))
    sudden: tuple[Kick | Aim | Jump, ...] = (*episode.kicks, *episode.aims, *episode.jumps)
    return {*held, *taken, *open_, *(event.step for event in sudden)}


def quiet_steps(episode: Episode) -> list[int]:
    """Return for each step the number of steps from it on without a force, and without an event after the first."""
    steps = (episode.samples - 1) * episode.substeps
    forced = np.full(steps, bool(episode.drags))
    for push in episode.pushes:
        forced[push.first : push.last + 1] = True
    stops = np.append(forced, True)
    stops[[step for step in event_steps(episode) if step < steps]] = True
    following = np.minimum.accumulate(np.where(stops, np.arange(steps + 1), steps)[::-1])[::-1]
    numbers: list[int] = np.where(forced, 0, following[1:] - np.arange(steps)).tolist()
    return numbers


def apply_events(world: World, episode: Episode, i: int) -> list[Kick]:
    """Apply holds, drive targets, jumps and kicks before step `i`; return the kicks."""
    for hold in episode.holds:
        if hold.first <= i < hold.until:
            world.hold(hold.body, hold.at)
        elif i == hold.until:
            world.free(hold.body)
    for aim in episode.aims:
        if aim.step == i:
            world.aim(aim.joint, aim.target)
    for passage in (p for p in episode.passages if i in (p.first, p.last) and p.first < p.last):
        pair = {passage.body, passage.through}
        others = (p for p in episode.passages if {p.body, p.through} == pair)
        world.collide(passage.body, passage.through, not any(p.first <= i < p.last for p in others))
    away = {hold.body for hold in episode.holds if hold.first <= i < hold.until}
    for jump in (jump for jump in episode.jumps if jump.step == i and jump.body not in away):
        state = np.asarray(world.state(jump.body))
        pose = jump.landing(np.array(episode.mounts[jump.body]), state)
        world.kick(jump.body, state[7:10], state[10:], pose)
    kicks = [kick for kick in episode.kicks if kick.step == i]
    for kick in kicks:  # engines fall by g h² too much in the first step; half a step less of g makes flight exact
        half_fall = np.array(episode.gravity) * (episode.step / 2)
        world.kick(kick.body, np.array(kick.linear) - half_fall, np.array(kick.angular))
    return kicks


def apply_grips(world: World, episode: Episode, paths: Any, held: dict[int, Any], i: int) -> None:
    """Begin and end grips before step `i`; `held` maps the number of a grip to its anchors."""
    for number, grip in enumerate(episode.grips):
        if i == grip.last and number in held:
            world.loose(number, grip)
        if grip.first <= i < grip.last and i == grip.first:
            hand = paths[grip.hand][0][i] if i < len(paths[grip.hand][0]) else paths[grip.hand][1][-1]
            held[number] = grip.anchors(hand, np.asarray(world.state(grip.body)))
            world.grip(number, grip, held[number])


def broken_grips(episode: Episode, held: dict[int, Any], states: Any) -> tuple[tuple[float, int, float], ...]:
    """Return time (s), number and length (m) of grips longer than `BREAK_LENGTH`; `states` (T, N, 13)."""
    found = []
    for number, anchors in held.items():
        grip = episode.grips[number]
        first, last = (-(-step // episode.substeps) for step in (grip.first, grip.last))
        lengths = grip.stretch(states[first:last, grip.hand], states[first:last, grip.body], anchors)
        over = np.flatnonzero(lengths > BREAK_LENGTH)
        if len(over):
            found.append(((first + int(over[0])) * episode.substeps * episode.step, number, float(lengths[over[0]])))
    return tuple(sorted(found))


def apply_forces(world: World, episode: Episode, i: int) -> None:
    """Apply forces and damping during step `i`."""
    for push in episode.pushes:
        if push.first <= i <= push.last:
            world.push(push.body, push.during(i), np.zeros(3))
    for drag in episode.drags:
        state = np.asarray(world.state(drag.body))
        turn, speed, spin = state[3:7], state[7:10], state[10:]
        torque = rotate(turn, np.array(drag.angular) * rotate(conjugate(turn), spin))
        world.push(drag.body, -drag.linear * speed, -torque)


def record_state(world: World, episode: Episode, kicks: list[Kick], into: Any) -> None:
    """Write the states of the dynamic bodies into `into` (N, 13)."""
    for body in episode.dynamic:
        into[body] = world.state(body)
    for kick in kicks:
        into[kick.body, 7:] = kick.linear + kick.angular


def to_body_frames(states: Any, episode: Episode) -> Any:
    """Return the states (T, N, 13) with poses of body frames instead of centre-of-mass frames."""
    mounts = np.array(episode.mounts)
    turns = states[..., 3:7] / np.linalg.norm(states[..., 3:7], axis=-1, keepdims=True)
    positions = states[..., :3] + rotate(turns, mounts[:, :3])
    return np.concatenate([positions, multiply(turns, mounts[:, 3:]), states[..., 7:]], axis=-1)
