"""The objects of a question as a picture shows them: where they are, in the world and in the picture, and how large."""

from __future__ import annotations

from collections.abc import Collection

from wmspec.compile.layout.values import Values
from wmspec.runtime.questions.model import Sighting
from wmspec.runtime.questions.patch import patch
from wmspec.runtime.questions.runs import Run
from wmspec.sim.scene.model import Frame

#: The properties whose words may tell an object from others.
_TELLING = ("color", "shape", "material")


def sightings(run: Run, frame: Frame, time: float, asked: Collection[str]) -> tuple[Sighting, ...]:
    """What a picture taken at a time (s) shows of the objects that can move, and of those that are `asked` about."""
    things = {thing.name for thing in run.values.spec.things if thing.kind == "object"}
    shown = {b.name: i for i, b in enumerate(run.scene.bodies) if b.name in things}
    names = [name for name, i in shown.items() if run.scene.bodies[i].motion != "static" or name in asked]
    found = []
    for name, pose in zip(names, run.poses(names, time).tolist(), strict=True):
        own, words = patch(frame, shown[name]), _words(run.values, name)
        place = tuple(pose[:3]), tuple(pose[3:])
        found.append(Sighting(name, words, name in asked, *place, own.share, own.across, own.down, own.color))
    return tuple(found)


def _words(values: Values, name: str) -> tuple[str, ...]:
    told = (values.property(name, key) for key in _TELLING if values.has(name, key))
    return tuple(word for word in told if isinstance(word, str))
