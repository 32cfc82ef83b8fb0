"""The loop of `wmspec.scene.episode` where nothing happens in between: MuJoCo makes all steps up to the next event.

The states are those that the loop makes step by step, to the bit. What touches is told by a contact sensor for each
pair of pieces that may touch, since the contacts of the steps in between are gone.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from wmspec.scene.contact import touchable
from wmspec.scene.episode import MEET, Episode, Recording, begin, beginnings, mounted
from wmspec.scene.model import Scene
from wmspec.scene.silence import silence
from wmspec.scene.transform import rotate

from .world import World

with silence():
    import mujoco
    import mujoco.rollout

#: With more pairs that may touch, the sensors take longer than the loop.
MOST_PAIRS = 24


def uneventful(scene: Scene, timeline: Episode) -> bool:
    """Whether all that is done to bodies is done between the steps, so that MuJoCo can be left alone for most."""
    lasting = (timeline.tracks, timeline.pushes, timeline.drags, timeline.grips, timeline.aims)
    few = sum(1 for _ in touchable(scene)) <= MOST_PAIRS
    return bool(timeline.dynamic) and not any(lasting) and not scene.joints and few


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
    steps, kind = (timeline.samples - 1) * timeline.substeps, mujoco.mjtState.mjSTATE_FULLPHYSICS
    whole = np.empty((steps + 1, mujoco.mj_stateSize(model, kind)))
    sensors = np.empty((steps, model.nsensordata))
    kicked, i = begin(world, timeline, 0), 0
    mujoco.mj_getState(model, data, whole[0], kind)
    for stop in [*sorted(step for step in beginnings(timeline) if 0 < step < steps), steps]:
        if stop == i + 1:  # what is held is put back before every step
            world.step()
            sensors[i] = data.sensordata
        else:
            before, warm = whole[i][None], data.qacc_warmstart.copy()[None]
            after, read = mujoco.rollout.rollout(model, data, before, nstep=stop - i, initial_warmstart=warm)
            whole[i + 1 : stop + 1], sensors[i:stop] = after[0], read[0]
            mujoco.mj_setState(model, data, whole[stop], kind)
        if world.warned.any():
            raise FloatingPointError(f"MuJoCo's warnings are {world.warned}")
        i = stop
        kicked += begin(world, timeline, i)
        mujoco.mj_getState(model, data, whole[i], kind)
    return Recording(mounted(_states(world, timeline, whole, kicked), timeline), _touching(scene, sensors))


def _states(world: World, timeline: Episode, whole: NDArray[np.float64], kicked: Any) -> NDArray[np.float64]:
    """What is recorded (T, N, 13), from MuJoCo's states before every step."""
    states = np.zeros((timeline.samples, len(timeline.start), 13))
    states[:, :, :7] = timeline.start
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
