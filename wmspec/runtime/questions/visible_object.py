"""The objects of a question in a picture: position in world and picture, and size."""

from __future__ import annotations

from collections.abc import Collection

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.runtime.questions.model import VisibleObject
from wmspec.runtime.questions.patch import patch
from wmspec.runtime.questions.runs import Run
from wmspec.sim.scene.model import Frame

#: Properties whose words distinguish objects.
_TELLING = ("color", "shape", "material")


def visible_objects(run: Run, frame: Frame, time: float, queried: Collection[str]) -> tuple[VisibleObject, ...]:
    """Return the movable and the queried objects as a picture at a time (s) shows them."""
    things = {thing.name for thing in run.values.spec.things if thing.kind == "object"}
    shown = {b.name: i for i, b in enumerate(run.scene.bodies) if b.name in things}
    names = [name for name, i in shown.items() if run.scene.bodies[i].motion != "static" or name in queried]
    found = []
    for name, pose in zip(names, run.poses(names, time).tolist(), strict=True):
        own, words = patch(frame, shown[name]), _words(run.values, name)
        place = tuple(pose[:3]), tuple(pose[3:])
        found.append(VisibleObject(name, words, name in queried, *place, own.share, own.across, own.down, own.color))
    return tuple(found)


def _words(values: Evaluator, name: str) -> tuple[str, ...]:
    words = (values.property(name, key) for key in _TELLING if values.has(name, key))
    return tuple(word for word in words if isinstance(word, str))
