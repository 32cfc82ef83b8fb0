"""Permitted differences of a body between engines: they grow with time in motion and with impact speeds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wmspec.runtime.compare.tolerance import Tolerances
from wmspec.sim.scene.model import Contact, Scene, Trace

Array = NDArray[np.float64]

#: Maximum speed (m/s) of a body at rest, an order of magnitude above solver jitter.
REST_SPEED = 0.01


@dataclass(frozen=True)
class Allowance:
    """Permitted difference of every body at every sample, (T, N): velocity (m/s) and position (m)."""

    velocity: Array
    position: Array


def allowance(scene: Scene, a: Trace, b: Trace, tolerances: Tolerances) -> Allowance:
    """Return the permitted differences: they grow with time in motion, and after impacts by the timing tolerance."""
    met = np.maximum(*(impact_speeds(scene, t, tolerances.event) for t in (a, b)))
    moving = np.maximum(*(np.linalg.norm(t.linear_velocity, axis=2) for t in (a, b))) > REST_SPEED
    velocity = tolerances.drift + tolerances.impact * met
    grown = np.cumsum(np.where(moving, velocity, 0.0), axis=0) / scene.rate
    return Allowance(velocity, tolerances.rest + tolerances.event * met + grown)


def impact_speeds(scene: Scene, trace: Trace, apart: float) -> Array:
    """Return the maximum impact speed (m/s) of each body so far, (T, N); zero before the first impact.

    Impacts also propagate to bodies in contact.
    """
    index = {name: i for i, name in enumerate(trace.bodies)}
    met = np.zeros(trace.position.shape[:2])
    for contact in impacts(trace, apart):
        i, j, k = index[contact.first], index[contact.second], sample_index(trace, contact.start)
        met[k:, [i, j]] = np.maximum(met[k:, [i, j]], closing_speed(trace, i, j, contact.start))
    movable = {b.name for b in scene.bodies if b.motion == "dynamic"}
    linked = [c for c in trace.contacts if {c.first, c.second} <= movable]
    for _ in movable:
        before = met.copy()
        for contact in linked:
            i, j = index[contact.first], index[contact.second]
            during = slice(sample_index(trace, contact.start), sample_index(trace, contact.stop) + 1)
            met[during, [i, j]] = met[during, [i, j]].max(axis=1, keepdims=True)
        np.maximum.accumulate(met, axis=0, out=met)
        if np.array_equal(met, before):
            break
    return met


def impacts(trace: Trace, apart: float) -> Iterator[Contact]:
    """Yield contacts of bodies that did not touch at the start and were separate for more than `apart` (s)."""
    stopped: dict[tuple[str, str], float] = {}
    for contact in trace.contacts:
        pair = (contact.first, contact.second)
        if contact.start > 0 and contact.start - stopped.get(pair, -np.inf) > apart:
            yield contact
        stopped[pair] = contact.stop


def closing_speed(trace: Trace, i: int, j: int, time: float) -> float:
    """Return the relative speed (m/s) of two bodies' centres just before `time` (s)."""
    k = max(sample_index(trace, time) - 1, 0)
    return float(np.linalg.norm(trace.linear_velocity[k, i] - trace.linear_velocity[k, j]))


def sample_index(trace: Trace, time: float) -> int:
    """Return the index of the last sample not after `time` (s)."""
    return int(np.searchsorted(trace.time, time + 1e-9, side="right")) - 1
