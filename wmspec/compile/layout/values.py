"""The values of a spec's properties for one assignment of its factors, worked out when asked for and once."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, TypeVar, cast

from wmspec.compile.layout import functions, placement
from wmspec.compile.layout.surfaces import Spot
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.limits import SECONDS
from wmspec.core.places import Location
from wmspec.core.space import Pose, Vector
from wmspec.lang.check.ir.evaluate import NoValue, evaluate
from wmspec.lang.check.ir.ir import Counterfactual, Expr, TaskSpec, Thing, Value
from wmspec.lang.check.tables import colors
from wmspec.lang.check.tables.verbs import VERBS
from wmspec.lang.check.tables.vocabulary import BY_MATERIAL, MOST_LENGTH, PROPERTIES, Slot
from wmspec.lang.check.types.types import A_LENGTH, A_TIME, POINT2, POINT3
from wmspec.lang.check.types.units import LENGTH, told
from wmspec.sim.materials import MATERIALS

T = TypeVar("T")

#: What a part takes from its object when it does not say it itself.
INHERITED = ("color", "material", "image", "repeats", "roughness", "metallic")
#: Gravity where no world says otherwise, m/s².
EARTH = 9.81
_LENGTHS = frozenset((A_LENGTH, POINT2, POINT3))
_MOMENT = Slot((A_TIME,), "", least=0)


class Values:
    """An environment for `evaluate`: the design's side of the language, without anything measured.

    `change` is the counterfactual under which to look at the world, if any; `own` are the levels without it. `key` is
    what every draw begins with: those of the places of scattered objects.
    """

    def __init__(
        self,
        spec: TaskSpec,
        assignment: Mapping[str, Any],
        change: Counterfactual | None = None,
        key: tuple[object, ...] = (),
    ) -> None:
        self.spec = spec
        self.own = assignment
        self.assignment = {**assignment, **change.levels} if change and change.change == "levels" else assignment
        self.change = change
        self.key = key
        self._changed = (change.owner, change.property) if change else ()
        self._lets = {let.name: let for let in spec.lets}
        self._things = {t.name: t for t in spec.things}
        self._known: dict[tuple[str, str], Any] = {}
        self._open: set[tuple[str, str]] = set()

    @cached_property
    def truth(self) -> Values:
        """The same without the counterfactual."""
        return Values(self.spec, self.own, None, self.key) if self.change else self

    # ------------------------------------------------------------ the environment

    def ref(self, name: str) -> Any:
        """A factor, nuisance or `let`, or `end`, the end of the episode."""
        if name in self.assignment:
            return self.assignment[name]
        return self.once(("", name), lambda: self._named(name))

    def during(self, time: float) -> bool:
        """Whether a time (s) is within the episode."""
        return -1e-9 <= time <= self.end + 1e-9

    def property(self, owner: str, name: str) -> object:
        """The value of a property or argument, of any kind. Raises WmsError with its place if it is impossible."""
        key = (owner, name)
        if key in self._known:
            return self._known[key]
        setting = self._things[owner].properties.get(name)
        if setting is None or owner in self._changed or not isinstance(setting.value, Value):
            return self.once(key, lambda: self._value(owner, name))
        constant = setting.value.value  # most are, and need no more than this
        self._check(self._things[owner], name, constant, setting.place)
        self._known[key] = constant
        return constant

    # The same by kind. The checker has seen to the kinds, so a TypeError from here is a mistake of wmspec's own.

    def number(self, owner: str, name: str) -> float:
        """A property that is a number, in SI units."""
        value = self.property(owner, name)
        if isinstance(value, float):
            return value
        if isinstance(value, int) and not isinstance(value, bool):
            return float(value)
        raise _mismatch(owner, name, value, "a number")

    def flag(self, owner: str, name: str) -> bool:
        """A property that is true or false."""
        value = self.property(owner, name)
        if isinstance(value, bool):
            return value
        raise _mismatch(owner, name, value, "true or false")

    def text(self, owner: str, name: str) -> str:
        """A property that is a text, or a word of a vocabulary such as a shape or a colour."""
        value = self.property(owner, name)
        if isinstance(value, str):
            return value
        raise _mismatch(owner, name, value, "a text")

    def reference(self, owner: str, name: str) -> str:
        """A property that refers to a thing of the spec: its name."""
        value = self.property(owner, name)
        if isinstance(value, str):
            return value
        raise _mismatch(owner, name, value, "the name of a thing")

    def references(self, owner: str, name: str) -> tuple[str, ...]:
        """A property that refers to several things of the spec: their names."""
        value = self.property(owner, name)
        if isinstance(value, tuple) and all(isinstance(each, str) for each in value):
            return value
        raise _mismatch(owner, name, value, "names of things")

    def pair(self, owner: str, name: str) -> tuple[float, float]:
        """A property that is two numbers, in SI units."""
        value = self.property(owner, name)
        if isinstance(value, tuple) and len(value) == 2:
            return value
        raise _mismatch(owner, name, value, "two numbers")

    def vector(self, owner: str, name: str) -> Vector:
        """A property that is three numbers, in SI units."""
        value = self.property(owner, name)
        if isinstance(value, tuple) and len(value) == 3:
            return value
        raise _mismatch(owner, name, value, "three numbers")

    def points(self, owner: str, name: str) -> tuple[tuple[float, ...], ...]:
        """A property that is a list of pairs or vectors, in SI units."""
        value = self.property(owner, name)
        if isinstance(value, tuple) and all(isinstance(each, tuple) for each in value):
            return value
        raise _mismatch(owner, name, value, "a list of points")

    def spot(self, owner: str, name: str = "at") -> Spot:
        """A property that is a point or a place on the ground."""
        value = self.property(owner, name)
        if isinstance(value, tuple) and 2 <= len(value) <= 3:
            return value
        raise _mismatch(owner, name, value, "a place")

    def direction(self, owner: str, name: str = "direction") -> float | str:
        """A property that is a heading: an angle (rad), or a word such as `left`."""
        value = self.property(owner, name)
        if isinstance(value, float | int | str):
            return value
        raise _mismatch(owner, name, value, "a direction")

    def call(self, function: str, arguments: tuple[Any, ...], **options: Any) -> Any:
        """A function of the design."""
        return functions.call(self, function, arguments, options)

    def once(self, key: tuple[str, str], make: Callable[[], T]) -> T:
        """What is worked out only once; `key` is its owner and name. Raises WmsError if it needs itself."""
        if key not in self._known:
            owner, name = key
            if key in self._open:
                named = f"{owner}.{name}" if owner else name
                raise ImpossibleValue(f"`{named}` depends on itself", self.place(owner) if owner else None)
            self._open.add(key)
            try:
                self._known[key] = make()
            finally:
                self._open.discard(key)
        return cast(T, self._known[key])

    # ------------------------------------------------------------ what there is

    def has(self, owner: str, name: str) -> bool:
        """Whether a property is set: by the spec, its default, the counterfactual, or for a part by its object."""
        thing, change = self._things[owner], self.change
        if name in thing.properties or (change and (change.owner, change.property) == (owner, name)):
            return True
        return thing.kind == "part" and name in INHERITED and self.has(thing.of, name)

    def place(self, owner: str, name: str = "") -> Location:
        """Where a thing, or one of its properties, stands in the text."""
        thing = self._things[owner]
        return thing.properties[name].place if name in thing.properties else thing.place

    def parts(self, owner: str) -> tuple[str, ...]:
        """The names of an object's parts, such as `rack.left`."""
        return self._parts.get(owner, ())

    def there(self, name: str) -> bool:
        """Whether an object or action is there at all; an action needs its object, and may be left out."""
        thing = self._things[name]
        if thing.kind == "action":
            change = self.change
            about = change is not None and change.owner == name
            happens = about if thing.added else not (about and change is not None and change.change == "without")
            return happens and ("object" not in thing.properties or self.there(self.reference(name, "object")))
        return "present" not in thing.properties or self.flag(name, "present")

    def ends(self, joint: str) -> tuple[str, ...]:
        """The objects that a joint joins: two, or one that it joins to the world."""
        return tuple(self.reference(joint, end) for end in ("of", "to") if self.has(joint, end))

    def acting(self, verb: str, owner: str) -> list[Thing]:
        """The actions of a verb that are done to an object."""
        return [
            a for a in self._actions.get(verb, ()) if self.reference(a.name, "object") == owner and self.there(a.name)
        ]

    @cached_property
    def _parts(self) -> dict[str, tuple[str, ...]]:
        parts: dict[str, tuple[str, ...]] = {}
        for thing in self.spec.things:
            if thing.kind == "part":
                parts[thing.of] = (*parts.get(thing.of, ()), thing.name)
        return parts

    @cached_property
    def assets(self) -> dict[str, tuple[Thing, ...]]:
        """The links and joints of every asset, without its base, by the name of that."""
        assets: dict[str, tuple[Thing, ...]] = {}
        for thing in self.spec.things:
            if thing.kind in ("object", "joint") and thing.of:
                assets[thing.of] = (*assets.get(thing.of, ()), thing)
        return assets

    @cached_property
    def _actions(self) -> dict[str, list[Thing]]:
        """The actions on objects by their verbs, without those of robots."""
        actions: dict[str, list[Thing]] = {}
        for thing in self.spec.things:
            if thing.kind == "action" and not thing.of:
                actions.setdefault(thing.verb, []).append(thing)
        return actions

    @cached_property
    def world(self) -> str | None:
        """The name of the world, if the spec says anything about it."""
        return next((t.name for t in self.spec.things if t.kind == "world"), None)

    @cached_property
    def gravity(self) -> float:
        """The acceleration of free fall, m/s²."""
        return self.number(self.world, "gravity") if self.world else EARTH

    @cached_property
    def end(self) -> float:
        """When the episode ends (s)."""
        return float(self.ref("end"))

    # ------------------------------------------------------------ where things are

    def pose(self, owner: str) -> Pose:
        """Where an object is in the world at the start. What rests on something touches it exactly."""
        return self.once((owner, "pose"), lambda: placement.pose(self, owner))

    # ------------------------------------------------------------ working a value out

    def _named(self, name: str) -> Any:
        if name == "end":
            end: float = evaluate(self.spec.horizon, self)
            if end > SECONDS.most:
                place = self.spec.observations[0].place if self.spec.observations else None
                raise ImpossibleValue(f"the episode {SECONDS.sentence} here", place, SECONDS.help)
            return end
        let = self._lets[name]
        return _evaluate(let.value, self, let.place)

    def _value(self, owner: str, name: str) -> Any:
        thing, change = self._things[owner], self.change
        setting = thing.properties.get(name)
        if change is not None and change.change == "order" and name == "start":
            return self._turn(change, owner)
        if change is not None and change.value is not None and (change.owner, change.property) == (owner, name):
            place, value = change.place, _evaluate(change.value, self.truth, change.place)  # said in terms of what was
        elif setting is not None:
            place, value = setting.place, _evaluate(setting.value, self, setting.place)
        elif thing.kind == "part" and name in INHERITED and self.has(thing.of, name):
            return self.property(thing.of, name)
        elif name in BY_MATERIAL:
            return self._of_material(owner, name)
        else:
            raise ImpossibleValue(f"`{owner}` does not say its {name}", thing.place)
        self._check(thing, name, value, place)
        return value

    def _check(self, thing: Thing, name: str, value: Any, place: Location) -> None:
        """Complain about numbers that are out of bounds."""
        if isinstance(value, str | bool):
            return
        slot = _slot(thing, name)
        for number in value if isinstance(value, tuple) else (value,):
            if isinstance(number, float) and (fault := _fault(number, slot)):
                raise ImpossibleValue(f"`{name}` of `{thing.name}` is {fault}", place)

    def _of_material(self, owner: str, name: str) -> Any:
        """What an object's material decides; a picture on it keeps its own colours."""
        if name != "color":
            return getattr(MATERIALS[self.text(owner, "material")], name)
        return colors.word(
            (1.0, 1.0, 1.0) if self.has(owner, "image") else MATERIALS[self.text(owner, "material")].color
        )

    def _turn(self, change: Counterfactual, owner: str) -> Any:
        """When an action starts if two have exchanged their turns; all others keep their time.

        The later one takes the start of the earlier one, which now ends when the later one would have.
        """
        start = self.truth.number(owner, "start")
        if owner not in (change.owner, change.property):
            return start
        early, late = sorted((change.owner, change.property), key=lambda a: self.truth.number(a, "start"))
        first, second = self.truth.number(early, "start"), self.truth.number(late, "start")
        return first if owner == late else second + self._lasts(late) - self._lasts(early)

    def _lasts(self, action: str) -> float:
        return self.truth.number(action, "duration") if self.has(action, "duration") else 0.0


def _mismatch(owner: str, name: str, value: object, kind: str) -> TypeError:
    return TypeError(f"`{owner}.{name}` is {value!r}, which is not {kind}: read it with the accessor of its kind")


def _evaluate(expr: Expr, values: Values, place: Location) -> Any:
    try:
        return evaluate(expr, values)
    except NoValue as error:
        raise ImpossibleValue(str(error), place) from None


def _fault(number: float, slot: Slot | None) -> str:
    """What a number is and must not be; empty if it is within bounds."""
    if slot and (wanted := slot.fault(number)):
        return f"{told(number, slot.dimension)} here; it must be {wanted}"
    if not math.isfinite(number):
        return "not finite"
    if abs(number) > MOST_LENGTH and slot and _LENGTHS.intersection(slot.types):
        return f"{told(number, LENGTH)} here; the most is {told(MOST_LENGTH, LENGTH)}"
    return ""


def _slot(thing: Thing, name: str) -> Slot | None:
    if thing.kind != "action":
        return PROPERTIES[thing.kind].get(name)
    if name in ("start", "duration"):
        return _MOMENT
    return None if thing.of else VERBS[thing.verb].arguments.get(name)
