"""Charts of two traces: the paths of bodies, and their distance over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wmspec.sim.scene.model import Array, Trace

#: Width and height of a chart, and its margin, in SVG units.
WIDTH, HEIGHT, MARGIN = 320.0, 240.0, 34.0
#: The most points of a line.
POINTS = 160
_AXES = "xyz"


@dataclass(frozen=True)
class Line:
    """A polyline: SVG `points`, the class of its engine, and what it is."""

    points: str
    kind: str
    meaning: str


@dataclass(frozen=True)
class Mark:
    """A text or a dot at a place."""

    x: float
    y: float
    text: str
    kind: str


@dataclass(frozen=True)
class Chart:
    """A chart for the template."""

    title: str
    lines: tuple[Line, ...]
    marks: tuple[Mark, ...]
    width: float = WIDTH
    height: float = HEIGHT


def path_chart(traces: tuple[Trace, Trace], bodies: Sequence[int]) -> Chart:
    """Return the paths of bodies in both engines, in the plane of the two axes along which they move farthest."""
    every = np.concatenate([trace.position[:, bodies].reshape(-1, 3) for trace in traces])
    low, high = every.min(axis=0), every.max(axis=0)
    a, b = sorted(np.argsort(high - low)[-2:].tolist())
    reach = max(float(high[a] - low[a]), float(high[b] - low[b]), 1e-3)
    scale = min(WIDTH - 2 * MARGIN, HEIGHT - 2 * MARGIN) / reach
    middle = (low + high) / 2

    def place(points: Array) -> Array:
        x = WIDTH / 2 + (points[:, a] - middle[a]) * scale
        y = HEIGHT / 2 - (points[:, b] - middle[b]) * scale
        return np.stack([x, y], axis=1)

    lines, marks = [], []
    for number, trace in enumerate(traces):
        for body in bodies:
            points = place(_thinned(trace.position[:, body]))
            lines.append(Line(_points(points), f"engine{number}", f"{trace.bodies[body]} in {trace.engine}"))
            marks.append(Mark(points[-1, 0], points[-1, 1], "", f"engine{number}"))
            if number == 0:
                marks.append(Mark(points[0, 0], points[0, 1], trace.bodies[body], "start"))
    title = f"paths along {_AXES[a]} and {_AXES[b]}, {reach * 100:.3g} cm across"
    return Chart(title, tuple(lines), tuple(marks))


def distance_chart(traces: tuple[Trace, Trace], bodies: Sequence[int], began: float | None) -> Chart:
    """Return the distance of each body between the engines over time, and the time of the divergence."""
    time, end = traces[0].time, max(float(traces[0].time[-1]), 1e-9)
    apart = {i: np.linalg.norm(traces[0].position[:, i] - traces[1].position[:, i], axis=1) for i in bodies}
    most = max([float(gap.max()) for gap in apart.values()] + [1e-6])

    def place(t: Array, gap: Array) -> Array:
        x = MARGIN + t / end * (WIDTH - 2 * MARGIN)
        return np.stack([x, HEIGHT - MARGIN - gap / most * (HEIGHT - 2 * MARGIN)], axis=1)

    lines = [
        Line(_points(_thinned(place(time, gap))), f"body{n}", f"{traces[0].bodies[i]}, up to {gap.max() * 100:.3g} cm")
        for n, (i, gap) in enumerate(apart.items())
    ]
    axis = place(np.array([0.0, 0.0, end]), np.array([most, 0.0, 0.0]))
    lines.append(Line(_points(axis), "axis", "axes"))
    marks = [
        Mark(MARGIN, MARGIN - 8, f"{most * 100:.3g} cm", "label"),
        Mark(WIDTH - MARGIN, HEIGHT - MARGIN + 18, f"{end:.3g} s", "label"),
    ]
    for n, (i, gap) in enumerate(apart.items()):
        marks.append(Mark(WIDTH - 4, float(place(time[-1:], gap[-1:])[0, 1]) - 6, traces[0].bodies[i], f"end body{n}"))
    if began is not None:
        x = MARGIN + began / end * (WIDTH - 2 * MARGIN)
        lines.append(
            Line(_points(np.array([[x, MARGIN], [x, HEIGHT - MARGIN]])), "began", f"divergence at {began:.3g} s")
        )
        marks.append(Mark(x, HEIGHT - MARGIN + 18, f"{began:.3g} s", "label"))
    return Chart("distance between the engines over time", tuple(lines), tuple(marks))


def _thinned(values: Array) -> Array:
    if len(values) <= POINTS:
        return values
    return np.asarray(values[np.linspace(0, len(values) - 1, POINTS).round().astype(int)])


def _points(points: Array) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points.tolist())
