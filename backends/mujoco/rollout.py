"""Steps an episode with `mujoco.rollout` up to the next event (see `wmspec.sim.scene.physics.episode`).

The states are those that the loop makes step by step, to the bit. What touches is told by a contact sensor for each
pair of pieces that may touch, since the contacts of the steps in between are gone. What moves as it is told is put in
its place before every step, while it moves. While it stands, MuJoCo is left alone; if it then stands elsewhere, if only
by the last bit since something struck it, these steps are made again one by one, and so are all after them.
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
from wmspec.sim.scene.physics.contact import touchable
from wmspec.sim.scene.physics.episode import MEET, Episode, Recording, begin, beginnings, expected, mounted

from .world import World

with silence():
    import mujoco
    import mujoco.rollout

#: With more pairs that may touch, the sensors take longer than the loop.
MOST_PAIRS = 24
#: Where what moves as it is told moves for a greater part of the time, the loop is as quick.
MOVING = 0.1
#: No more steps are made again.
TRIED = 512

#: How bodies move as they are told, by their numbers: what `Track.steps` says.
Paths = dict[int, tuple[Any, Any, Any]]


def uneventful(scene: Scene, timeline: Episode) -> bool:
    """Whether all that is done to bodies is done between the steps, so that MuJoCo can be left alone for most."""
    lasting = (timeline.pushes, timeline.drags, timeline.grips, timeline.aims)
    few = sum(1 for _ in touchable(scene)) <= MOST_PAIRS
    alone = bool(timeline.dynamic) and not any(lasting) and not scene.joints and few
    return alone and _moving(timeline) <= MOVING * (timeline.samples - 1) / timeline.rate


def _moving(timeline: Episode) -> float:
    """For how long (s) what can be touched moves as it is told, one after the other."""
    end, moving = (timeline.samples - 1) / timeline.rate, 0.0
    for track in (track for track in timeline.tracks if track.body not in timeline.unfelt):
        lasting = np.diff(np.minimum([*track.times, end], end))
        moving += float(lasting[np.any([*zip(track.velocities, track.spins, strict=True)], axis=(1, 2))].sum())
    return moving


def _steps(timeline: Episode) -> int:
    return (timeline.samples - 1) * timeline.substeps


def _paths(timeline: Episode) -> Paths:
    times = np.arange(_steps(timeline) + 1) * timeline.step
    return {track.body: track.steps(times) for track in timeline.tracks if track.body not in timeline.unfelt}


def _stands(paths: Paths, steps: int) -> NDArray[np.bool_]:
    """Before which steps (T,) all that moves as it is told is at rest where it was before the step before."""
    stands = np.ones(steps, bool)
    for here, _, speeds in paths.values():
        rests = ~speeds.any(axis=1)
        stands[1:] &= rests[1:] & rests[:-1] & (here[1:] == here[:-1]).all(axis=1)
    return stands


def sensed(text: str, scene: Scene) -> str:
    """MJCF with a sensor for every pair of pieces that may touch: how many contacts it has, and the nearest."""
    sensors = "".join(
        f"<contact geom1={quoteattr(f'{a.name}/{g.name}')} geom2={quoteattr(f'{b.name}/{h.name}')} "
        'num="1" reduce="mindist" data="found dist"/>'
        for a, g, b, h in touchable(scene)
    )
    head, end, rest = text.rpartition("</mujoco>")
    return f"{head}<sensor>{sensors}</sensor>{end}{rest}"


def play(world: World, scene: Scene, timeline: Episode) -> Recording:
    """Play the episode in a freshly built world of the sensed model. Raises FloatingPointError on a warning."""
    model, data = world.model, world.data
    steps, kind, paths = _steps(timeline), mujoco.mjtState.mjSTATE_FULLPHYSICS, _paths(timeline)
    whole = np.empty((steps + 1, mujoco.mj_stateSize(model, kind)))
    sensors = np.empty((steps, model.nsensordata))
    drive, kicked, i, struck = world.driven(paths), begin(world, timeline, 0), 0, False
    mujoco.mj_getState(model, data, whole[0], kind)
    stops, told, spare = _stops(timeline, paths), paths and world.told(paths), paths and copy(data)
    while i < steps:
        drive(i)
        stop = i + 1 if struck else stops[bisect_right(stops, i)]
        if stop > i + 1:
            whole[i + 1 : stop + 1], sensors[i:stop], struck = _left_alone(world, told, spare, i, stop)
        if stop == i + 1 or struck:  # what is held is put back before every step
            stop = i + 1
            world.step()
            sensors[i] = data.sensordata
        i = stop
        kicked += begin(world, timeline, i)
        mujoco.mj_getState(model, data, whole[i], kind)
    return Recording(mounted(_states(world, timeline, whole, kicked), timeline), _touching(scene, sensors))


def _stops(timeline: Episode, paths: Paths) -> list[int]:
    """The steps before which something happens, what moves as it is told has moved, or enough would be made again."""
    steps = _steps(timeline)
    often = range(0, steps, TRIED) if paths else ()
    stops = beginnings(timeline).union(np.flatnonzero(~_stands(paths, steps)).tolist(), often)
    return [*sorted(step for step in stops if 0 < step < steps), steps]


def _left_alone(
    world: World, told: Any, spare: Any, i: int, stop: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], bool]:
    """The states after the steps `i` to `stop`, which MuJoCo makes by itself, and what its sensors say.

    Whether what is `told` to stand was struck: then all is as it was, as the `spare` data keep it meanwhile.
    """
    model, data, kind = world.model, world.data, mujoco.mjtState.mjSTATE_FULLPHYSICS
    before, warm = np.empty((1, mujoco.mj_stateSize(model, kind))), data.qacc_warmstart.copy()[None]
    mujoco.mj_getState(model, data, before[0], kind)
    if told:
        mujoco.mj_copyData(spare, model, data)
    after, read = mujoco.rollout.rollout(model, data, before, nstep=stop - i, initial_warmstart=warm)
    if world.warned.any():
        raise FloatingPointError(f"MuJoCo's warnings are {world.warned}")
    if told:
        (places, poses), (rates, speeds) = told
        stood, moved = after[0][:-1, 1 + places], after[0][:-1, 1 + model.nq + rates]
        if (stood != poses[i + 1 : stop]).any() or (moved != speeds[i + 1 : stop]).any():
            mujoco.mj_copyData(data, model, spare)
            return after[0], read[0], True
    mujoco.mj_setState(model, data, after[0, -1], kind)
    return after[0], read[0], False


def _states(world: World, timeline: Episode, whole: NDArray[np.float64], kicked: Any) -> NDArray[np.float64]:
    """What is recorded (T, N, 13), from MuJoCo's states before every step."""
    states: NDArray[np.float64] = expected(timeline)
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
    """The pairs of bodies that touch in every step: from when they are `MEET` apart until they have no contact."""
    steps = len(sensors)
    index = {body.name: i for i, body in enumerate(scene.bodies)}
    near: dict[tuple[int, int], NDArray[np.bool_]] = {}
    meet: dict[tuple[int, int], NDArray[np.bool_]] = {}
    for k, (a, _, b, _) in enumerate(touchable(scene)):
        pair, contact = (index[a.name], index[b.name]), sensors[:, 2 * k] > 0
        near[pair] = near.get(pair, np.zeros(steps, bool)) | contact
        meet[pair] = meet.get(pair, np.zeros(steps, bool)) | (contact & (sensors[:, 2 * k + 1] < MEET))
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
