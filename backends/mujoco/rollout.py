"""Steps an episode with `mujoco.rollout` up to the next event (see `wmspec.sim.scene.physics.episode`).

States equal those of the step loop to the bit. Contacts come from a contact sensor for each pair of geoms that can
collide, because contacts of intermediate steps are lost. Kinematic bodies are set before every step while they move.
While they rest, MuJoCo steps alone; if an impact displaces one, even by a bit, these and all later steps are repeated
one by one.
"""

from __future__ import annotations

from bisect import bisect_right
from copy import copy
from itertools import pairwise
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from wmspec.core.native_output import silence
from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.model.transform import rotate
from wmspec.sim.scene.physics.contact import colliding_geoms
from wmspec.sim.scene.physics.episode import (
    TOUCH_BEGIN,
    Episode,
    Recording,
    apply_events,
    event_steps,
    path_steps,
    scripted_states,
    to_body_frames,
)

from .world import World, warning_text

with silence():
    import mujoco
    import mujoco.rollout

#: With more pairs, sensors take longer than the step loop.
MAX_PAIRS = 24
#: If kinematic bodies move for a larger fraction of the time, the step loop is as fast.
MAX_MOVING_FRACTION = 0.1
#: Largest number of repeated steps.
MAX_REDONE_STEPS = 512

#: Paths of kinematic bodies by number (see `KinematicPath.steps`).
Paths = dict[int, tuple[Any, Any, Any]]


def is_uneventful(scene: Scene, timeline: Episode) -> bool:
    """Whether all actions fall between steps, so that MuJoCo can step alone most of the time."""
    lasting = (timeline.pushes, timeline.drags, timeline.grips, timeline.aims, timeline.passages)
    few = sum(1 for _ in colliding_geoms(scene)) <= MAX_PAIRS
    alone = bool(timeline.dynamic) and not any(lasting) and not scene.joints and few
    return alone and _moving_time(timeline) <= MAX_MOVING_FRACTION * (timeline.samples - 1) / timeline.rate


def _moving_time(timeline: Episode) -> float:
    """Return the total time (s) during which colliding kinematic bodies move."""
    end, moving = (timeline.samples - 1) / timeline.rate, 0.0
    for track in (track for track in timeline.tracks if track.body not in timeline.untouchable):
        if any(track.surface):
            moving += end
            continue
        lasting = np.diff(np.minimum([*track.times, end], end))
        moving += float(lasting[np.any([*zip(track.velocities, track.spins, strict=True)], axis=(1, 2))].sum())
    return moving


def _steps(timeline: Episode) -> int:
    return (timeline.samples - 1) * timeline.substeps


def _paths(timeline: Episode) -> Paths:
    tracks = (track for track in timeline.tracks if track.body not in timeline.untouchable)
    return {track.body: path_steps(track, _steps(timeline), timeline.step) for track in tracks}


def _is_at_rest(paths: Paths, steps: int) -> NDArray[np.bool_]:
    """Return for which steps (T,) all kinematic bodies rest at their previous pose."""
    stands = np.ones(steps, bool)
    for here, _, speeds in paths.values():
        rests = ~speeds.any(axis=1)
        stands[1:] &= rests[1:] & rests[:-1] & (here[1:] == here[:-1]).all(axis=1)
    return stands


def with_contact_sensors(text: str, scene: Scene) -> str:
    """Return the MJCF with a sensor per pair of geoms that can collide: number of contacts, and smallest distance."""
    sensors = "".join(
        f"<contact geom1={quoteattr(f'{a.name}/{g.name}')} geom2={quoteattr(f'{b.name}/{h.name}')} "
        'num="1" reduce="mindist" data="found dist"/>'
        for a, g, b, h in colliding_geoms(scene)
    )
    head, end, rest = text.rpartition("</mujoco>")
    return f"{head}<sensor>{sensors}</sensor>{end}{rest}"


def play(world: World, scene: Scene, timeline: Episode) -> Recording:
    """Execute the episode in a new world of the model with sensors. Raises FloatingPointError on a warning."""
    model, data = world.model, world.data
    steps, kind, paths = _steps(timeline), mujoco.mjtState.mjSTATE_FULLPHYSICS, _paths(timeline)
    whole = np.empty((steps + 1, mujoco.mj_stateSize(model, kind)))
    sensors = np.empty((steps, model.nsensordata))
    drive, kicked, i, struck = world.driven(paths), apply_events(world, timeline, 0), 0, False
    mujoco.mj_getState(model, data, whole[0], kind)
    stops, led, spare = _event_steps(timeline, paths), paths and world.kinematic_states(paths), paths and copy(data)
    while i < steps:
        drive(i)
        stop = i + 1 if struck else stops[bisect_right(stops, i)]
        if stop > i + 1:
            whole[i + 1 : stop + 1], sensors[i:stop], struck = _advance(world, led, spare, i, stop)
        if stop == i + 1 or struck:  # held bodies are reset before every step
            stop = i + 1
            world.step()
            sensors[i] = data.sensordata
        i = stop
        kicked += apply_events(world, timeline, i)
        mujoco.mj_getState(model, data, whole[i], kind)
    return Recording(to_body_frames(_states(world, timeline, whole, kicked), timeline), _touching(scene, sensors))


def _event_steps(timeline: Episode, paths: Paths) -> list[int]:
    """Return the steps before which an event happens, a kinematic body has moved, or the redo limit is reached."""
    steps = _steps(timeline)
    often = range(0, steps, MAX_REDONE_STEPS) if paths else ()
    stops = event_steps(timeline).union(np.flatnonzero(~_is_at_rest(paths, steps)).tolist(), often)
    return [*sorted(step for step in stops if 0 < step < steps), steps]


def _advance(
    world: World, led: Any, spare: Any, i: int, stop: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], bool]:
    """Advance from step `i` to `stop` without events; return states, sensor data, and whether a resting body was
    struck.

    If it was struck, the state is restored from `spare`.
    """
    model, data, kind = world.model, world.data, mujoco.mjtState.mjSTATE_FULLPHYSICS
    before, warm = np.empty((1, mujoco.mj_stateSize(model, kind))), data.qacc_warmstart.copy()[None]
    mujoco.mj_getState(model, data, before[0], kind)
    if led:
        mujoco.mj_copyData(spare, model, data)
    after, read = mujoco.rollout.rollout(model, data, before, nstep=stop - i, initial_warmstart=warm)
    if world.warned.any():
        raise FloatingPointError(warning_text(world.warned, world.data.time))
    if led:
        (places, poses), (rates, speeds) = led
        stood, moved = after[0][:-1, 1 + places], after[0][:-1, 1 + model.nq + rates]
        if (stood != poses[i + 1 : stop]).any() or (moved != speeds[i + 1 : stop]).any():
            mujoco.mj_copyData(data, model, spare)
            return after[0], read[0], True
    mujoco.mj_setState(model, data, after[0, -1], kind)
    return after[0], read[0], False


def _states(world: World, timeline: Episode, whole: NDArray[np.float64], kicked: Any) -> NDArray[np.float64]:
    """Return the recorded states (T, N, 13) from MuJoCo's states before every step."""
    states: NDArray[np.float64] = scripted_states(timeline)
    sampled = whole[:: timeline.substeps]
    for body in timeline.dynamic:
        place, speed = 1 + world.qpos[body], 1 + world.model.nq + world.qvel[body]
        pose, rates = sampled[:, place : place + 7], sampled[:, speed : speed + 6]
        states[:, body] = np.concatenate([pose, rates[:, :3], rotate(pose[:, 3:], rates[:, 3:])], axis=1)
    for kick in kicked:
        if kick.step % timeline.substeps == 0:
            states[kick.step // timeline.substeps, kick.body, 7:] = kick.linear + kick.angular
    return states


def _touching(scene: Scene, sensors: NDArray[np.float64]) -> list[set[tuple[int, int]]]:
    """Return the touching pairs of every step: from distance `TOUCH_BEGIN` until no contact remains."""
    steps = len(sensors)
    index = {body.name: i for i, body in enumerate(scene.bodies)}
    near: dict[tuple[int, int], NDArray[np.bool_]] = {}
    meet: dict[tuple[int, int], NDArray[np.bool_]] = {}
    for k, (a, _, b, _) in enumerate(colliding_geoms(scene)):
        pair, contact = (index[a.name], index[b.name]), sensors[:, 2 * k] > 0
        near[pair] = near.get(pair, np.zeros(steps, bool)) | contact
        meet[pair] = meet.get(pair, np.zeros(steps, bool)) | (contact & (sensors[:, 2 * k + 1] < TOUCH_BEGIN))
    numbers = np.arange(steps)
    pairs, touch = list(near), np.zeros((len(near), steps), bool)
    for row, pair in enumerate(pairs):
        parted = np.maximum.accumulate(np.where(~near[pair], numbers, -1))
        met = np.maximum.accumulate(np.where(meet[pair], numbers, -1))
        touch[row] = near[pair] & (met > parted)
    touching: list[set[tuple[int, int]]] = []
    changes = [0, *(np.flatnonzero((touch[:, 1:] != touch[:, :-1]).any(axis=0)) + 1).tolist(), steps]
    for first, last in pairwise(changes):
        touching += [{pair for pair, now in zip(pairs, touch[:, first].tolist(), strict=True) if now}] * (last - first)
    return touching
