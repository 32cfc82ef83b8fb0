"""How far a body may be from itself in another engine: more the longer it moves and the harder it was met."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wmspec.runtime.compare.tolerance import Tolerances
from wmspec.sim.scene.model import Contact, Scene, Trace

Array = NDArray[np.float64]

#: m/s; a body that is slower is at rest. A solver's jitter stays an order of magnitude below.
STILL = 0.01


@dataclass(frozen=True)
class Allowance:
    """By how much every body may differ at every sample, (T, N): in velocity (m/s) and in place (m)."""

    velocity: Array
    position: Array


def allowance(scene: Scene, a: Trace, b: Trace, tolerances: Tolerances) -> Allowance:
    """What the tolerances give: more for each second of motion, and after an impact for the time that it may be off."""
    met = np.maximum(*(met_at(scene, t, tolerances.event) for t in (a, b)))
    moving = np.maximum(*(np.linalg.norm(t.linear_velocity, axis=2) for t in (a, b))) > STILL
    velocity = tolerances.drift + tolerances.impact * met
    grown = np.cumsum(np.where(moving, velocity, 0.0), axis=0) / scene.rate
    return Allowance(velocity, tolerances.rest + tolerances.event * met + grown)


def met_at(scene: Scene, trace: Trace, apart: float) -> Array:
    """The largest speed (m/s) with which each body has met another so far, (T, N); zero until then.

    What lies against a body that is met is met through it.
    """
    index = {name: i for i, name in enumerate(trace.bodies)}
    met = np.zeros(trace.position.shape[:2])
    for contact in impacts(trace, apart):
        i, j, k = index[contact.first], index[contact.second], sample(trace, contact.start)
        met[k:, [i, j]] = np.maximum(met[k:, [i, j]], closing(trace, i, j, contact.start))
    movable = {b.name for b in scene.bodies if b.motion == "dynamic"}
    linked = [c for c in trace.contacts if {c.first, c.second} <= movable]
    for _ in movable:
        before = met.copy()
        for contact in linked:
            i, j = index[contact.first], index[contact.second]
            during = slice(sample(trace, contact.start), sample(trace, contact.stop) + 1)
            met[during, [i, j]] = met[during, [i, j]].max(axis=1, keepdims=True)
        np.maximum.accumulate(met, axis=0, out=met)
        if np.array_equal(met, before):
            break
    return met


def impacts(trace: Trace, apart: float) -> Iterator[Contact]:
    """The contacts of bodies that did not touch at the start and were apart for longer than `apart` (s) before."""
    stopped: dict[tuple[str, str], float] = {}
    for contact in trace.contacts:
        pair = (contact.first, contact.second)
        if contact.start > 0 and contact.start - stopped.get(pair, -np.inf) > apart:
            yield contact
        stopped[pair] = contact.stop


def closing(trace: Trace, i: int, j: int, time: float) -> float:
    """The speed (m/s) of two bodies' middles relative to one another just before `time` (s)."""
    k = max(sample(trace, time) - 1, 0)
    return float(np.linalg.norm(trace.linear_velocity[k, i] - trace.linear_velocity[k, j]))


def sample(trace: Trace, time: float) -> int:
    """The last sample that is not after `time` (s)."""
    return int(np.searchsorted(trace.time, time + 1e-9, side="right")) - 1
