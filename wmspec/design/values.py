"""The values of a spec's properties for one assignment of its factors, worked out when asked for and once."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from wmspec.check.evaluate import evaluate
from wmspec.check.ir import Counterfactual, TaskSpec
from wmspec.check.verbs import VERBS
from wmspec.check.vocabulary import BY_MATERIAL, COLORS, PROPERTIES, Slot
from wmspec.errors import WmsError
from wmspec.looks import MATERIALS

Point = tuple[float, float, float]


class Values:
    """An environment for `evaluate`: the design's side of the language, without anything measured.

    `change` is the counterfactual under which to look at the world, if any.
    """

    def __init__(self, spec: TaskSpec, assignment: Mapping[str, Any], change: Counterfactual | None = None) -> None:
        self.spec = spec
        self.assignment = assignment
        self.change = change
        self._lets = {let.name: let.value for let in spec.lets}
        self._things = {t.name: t for t in spec.things}
        self._known: dict[tuple[str, str], Any] = {}
        self._open: set[tuple[str, str]] = set()

    # ------------------------------------------------------------ the environment

    def ref(self, name: str) -> Any:
        """A factor, nuisance or `let`, or `end`, the end of the episode."""
        if name in self.assignment:
            return self.assignment[name]
        key = ("", name)
        if key not in self._known:
            expr = self.spec.horizon if name == "end" else self._lets[name]
            self._known[key] = evaluate(expr, self)
        return self._known[key]

    def property(self, owner: str, name: str) -> Any:
        """The value of a property or argument. Raises WmsError with its place if it is impossible."""
        key = (owner, name)
        if key not in self._known:
            if key in self._open:
                raise WmsError(f"{self._things[owner].place}: `{owner}.{name}` depends on itself")
            self._open.add(key)
            try:
                self._known[key] = self._value(owner, name)
            finally:
                self._open.discard(key)
        return self._known[key]

    def has(self, owner: str, name: str) -> bool:
        """Whether a property is set, by the spec, its default or the counterfactual."""
        changed = self.change is not None and (self.change.owner, self.change.property) == (owner, name)
        return changed or name in self._things[owner].properties

    def call(self, function: str, arguments: tuple[Any, ...]) -> Any:
        """A function of the design."""
        match function, arguments:
            case "toward", (subject, target):
                (x, y, _), (to_x, to_y, _) = self.position(subject), self.position(target)
                return math.atan2(to_y - y, to_x - x)
            case "opposite", (angle,):
                return angle + math.pi
            case "rgb", parts:
                return "rgb:" + ",".join(f"{min(max(p, 0.0), 1.0):.6g}" for p in parts)
            case "max", times:
                return max((t for time in times for t in (time if isinstance(time, tuple) else (time,))), default=0.0)
        raise AssertionError(function)

    def _value(self, owner: str, name: str) -> Any:
        thing = self._things[owner]
        setting = thing.properties.get(name)
        change = self.change
        if change is not None and change.value is not None and (change.owner, change.property) == (owner, name):
            before = Values(self.spec, self.assignment)  # the change is said in terms of what was
            value, place = evaluate(change.value, before), change.place
        elif setting is None and name in BY_MATERIAL:
            return self._of_material(owner, name)
        elif setting is None:
            raise WmsError(f"{thing.place}: `{owner}` does not say its {name}")
        else:
            value, place = evaluate(setting.value, self), setting.place
        table = VERBS[thing.verb].arguments if thing.kind == "action" else PROPERTIES[thing.kind]
        slot = table.get(name, Slot((), "", least=0))
        for number in value if isinstance(value, tuple) and name == "size" else (value,):
            if isinstance(number, float) and (reason := slot.fault(number)):
                raise WmsError(f"{place}: `{name}` of `{owner}` is {number:g} here; it must be {reason}")
            if isinstance(number, float) and not math.isfinite(number):
                raise WmsError(f"{place}: `{name}` of `{owner}` is not finite")
        return value

    def _of_material(self, owner: str, name: str) -> Any:
        """What an object's material decides; a picture on it keeps its own colours."""
        if name != "color":
            return getattr(MATERIALS[self.property(owner, "material")], name)
        if self.has(owner, "image"):
            return "rgb:1,1,1"
        return word(MATERIALS[self.property(owner, "material")].color)

    # ------------------------------------------------------------ geometry

    def extent(self, owner: str) -> Point:
        """The edges (m) of the upright box around an object that is not turned."""
        size = self.property(owner, "size")
        if isinstance(size, tuple):
            if self.property(owner, "shape") != "box":
                raise WmsError(f"{self._things[owner].properties['size'].place}: only a box has three edges")
            x, y, z = size
            return (x, y, z)
        across, up = size, size
        shape = self.property(owner, "shape")
        if shape == "capsule":
            across = size / 2
        if self.has(owner, "radius"):
            across = up = 2 * self.property(owner, "radius")
        if self.has(owner, "height") and shape in ("cylinder", "cone", "capsule"):
            up = self.property(owner, "height")
        if shape == "capsule" and up <= across:
            raise WmsError(f"{self._things[owner].place}: the capsule `{owner}` is not higher than it is wide")
        return (across, across, up)

    def position(self, owner: str) -> Point:
        """Where the middle of an object is in the world (m). Resting objects touch what they rest on exactly."""
        at = self.property(owner, "at")
        if not self.has(owner, "on"):
            return (*at, self.extent(owner)[2] / 2) if len(at) == 2 else at
        if len(at) == 3:
            raise WmsError(f"{self._things[owner].place}: `{owner}` rests on something, so its place there is (x, y)")
        base = self.property(owner, "on")
        x, y, z = self.position(base)
        top = z + self.extent(base)[2] / 2
        turn = self.property(base, "yaw")
        cos, sin = math.cos(turn), math.sin(turn)
        return (x + cos * at[0] - sin * at[1], y + sin * at[0] + cos * at[1], top + self.extent(owner)[2] / 2)


def rgb(color: str) -> Point:
    """The sRGB parts of a colour word or of `rgb(...)`."""
    if color.startswith("rgb:"):
        r, g, b = (float(p) for p in color[4:].split(","))
        return (r, g, b)
    return COLORS[color]


def word(color: Point) -> str:
    """The word for a colour by its sRGB parts, or else `rgb:...`."""
    said = next((name for name, parts in COLORS.items() if parts == color), None)
    return said or "rgb:" + ",".join(f"{part:.6g}" for part in color)
