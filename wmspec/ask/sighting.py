"""The objects of a question as a picture shows them: where they are, in the world and in the picture, and how large."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from wmspec.ask.model import Sighting
from wmspec.ask.runs import Run
from wmspec.layout.values import Values
from wmspec.scene.model import Frame

#: The properties whose words may tell an object from others.
_TELLING = ("color", "shape", "material")


def sightings(run: Run, frame: Frame, time: float, asked: Collection[str]) -> tuple[Sighting, ...]:
    """What a picture taken at a time (s) shows of the objects that can move, and of those that are `asked` about."""
    things = {thing.name for thing in run.values.spec.things if thing.kind == "object"}
    shown = {b.name: i for i, b in enumerate(run.scene.bodies) if b.name in things}
    names = [name for name, i in shown.items() if run.scene.bodies[i].motion != "static" or name in asked]
    return tuple(
        _sighting(frame.ids == shown[name], frame, (name, _words(run.values, name), name in asked), pose.tolist())
        for name, pose in zip(names, run.poses(names, time), strict=True)
    )


def _sighting(
    mask: NDArray[np.bool_], frame: Frame, what: tuple[str, tuple[str, ...], bool], pose: Sequence[float]
) -> Sighting:
    """An object that a picture shows where `mask` (h, w) is, in a pose (7,)."""
    position, orientation = tuple(pose[:3]), tuple(pose[3:])
    pixels = int(mask.sum())
    if not pixels:
        return Sighting(*what, position, orientation, 0.0, None, None, None)
    down, across = (
        float((mask.sum(axis=1 - axis) @ np.arange(side) / pixels + 0.5) / side) for axis, side in enumerate(mask.shape)
    )
    color = tuple(frame.rgb[mask].mean(axis=0) / 255.0)
    return Sighting(*what, position, orientation, float(mask.mean()), across, down, tuple(map(float, color)))


def _words(values: Values, name: str) -> tuple[str, ...]:
    told = (values.property(name, key) for key in _TELLING if values.has(name, key))
    return tuple(word for word in told if isinstance(word, str))
