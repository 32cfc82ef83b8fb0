"""Compares one episode in two engines: trajectories, first contacts, and rest."""

from __future__ import annotations

from collections.abc import Iterator, Set

import numpy as np

from wmspec.runtime.compare.allow import REST_SPEED, Array, allowance, closing_speed, impacts, sample_index
from wmspec.runtime.compare.explain import cause
from wmspec.runtime.compare.model import Comparison, Event, Gap, Rest
from wmspec.runtime.compare.regimes import regimes
from wmspec.runtime.compare.tolerance import Tolerances
from wmspec.sim.scene.model import Body, Scene, Trace
from wmspec.sim.scene.render.visible_rotation import visible_angle


def compare(run: str, scene: Scene, a: Trace, b: Trace, tolerances: Tolerances) -> Comparison:
    """Return the differences between two traces of a scene."""
    allowed = allowance(scene, a, b, tolerances)
    moving = [i for i, body in enumerate(scene.bodies) if body.motion != "static"]
    gaps = tuple(_gap(scene.bodies[i], i, a, b, allowed.position[:, i], tolerances.angle) for i in moving)
    events = tuple(_events(a, b, allowed.position, tolerances.event))
    rests = tuple(_rests(scene, moving, a, b, allowed.velocity[-1]))
    why = cause(run, scene, (a, b), (gaps, events, rests), tolerances.event)
    entered = regimes(scene, (a, b), tolerances.event)
    return Comparison(run, (a.engine, b.engine), gaps, events, rests, why, entered)


def _gap(body: Body, i: int, a: Trace, b: Trace, allowed: Array, most: float) -> Gap:
    apart = np.linalg.norm(a.position[:, i] - b.position[:, i], axis=1)
    angle = visible_angle(body, a.orientation[:, i], b.orientation[:, i])
    beyond = (apart > allowed) | (angle > most)
    worst = int(apart.argmax())
    return Gap(
        body=body.name,
        position=float(apart[worst]),
        allowed=float(allowed[worst]),
        angle=float(angle.max()),
        end=float(apart[-1]),
        began=float(a.time[beyond.argmax()]) if beyond.any() else None,
    )


def _events(a: Trace, b: Trace, allowed: Array, event: float) -> Iterator[Event]:
    """Yield first contacts. A body `d` (m) off at speed `v` (m/s) may arrive `d / v` (s) off."""
    index = {name: i for i, name in enumerate(a.bodies)}
    # In either engine: some report no contacts of held objects until their release.
    resting = {(c.first, c.second) for t in (a, b) for c in t.contacts if c.start <= event}
    firsts = [_firsts(t, event, resting) for t in (a, b)]
    for pair in sorted(firsts[0].keys() | firsts[1].keys(), key=lambda p: (index[p[0]], index[p[1]])):
        times = (firsts[0].get(pair), firsts[1].get(pair))
        seen = [(t, trace) for t, trace in zip(times, (a, b), strict=True) if t is not None]
        time, trace = min(seen, key=lambda s: s[0])
        i, j = index[pair[0]], index[pair[1]]
        slack = (
            allowed[sample_index(trace, time), [i, j]].sum() / max(closing_speed(trace, i, j, time), REST_SPEED) + event
        )
        latest = max(t for t, _ in seen) if len(seen) == 2 else float(a.time[-1])
        yield Event(*pair, times, bool(latest - time <= slack))


def _firsts(trace: Trace, apart: float, resting: Set[tuple[str, str]]) -> dict[tuple[str, str], float]:
    """Return the times (s) of first contacts, except of pairs in `resting` contact from the start."""
    firsts: dict[tuple[str, str], float] = {}
    for contact in impacts(trace, apart):
        pair = (contact.first, contact.second)
        if pair not in resting:
            firsts.setdefault(pair, contact.start)
    return firsts


def _rests(scene: Scene, moving: list[int], a: Trace, b: Trace, rate: Array) -> Iterator[Rest]:
    """Yield bodies at rest at the end in one engine only, beyond the permitted velocity differences (N,)."""
    for i in moving:
        speeds = [float(np.linalg.norm(t.linear_velocity[-1, i])) for t in (a, b)]
        if min(speeds) < REST_SPEED and max(speeds) - min(speeds) > REST_SPEED + rate[i]:
            yield Rest(scene.bodies[i].name, (speeds[0], speeds[1]))
