"""Evaluates the properties of a spec for one assignment of its factors, lazily and once each."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, TypeVar, cast

from wmspec.compile.layout import functions, placement
from wmspec.compile.layout.surfaces import Spot
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.limits import EPISODE_SECONDS
from wmspec.core.places import Location
from wmspec.core.space import Pose, Vector
from wmspec.lang.check.ir.evaluate import NoValue, Unchanged, evaluate
from wmspec.lang.check.ir.ir import Counterfactual, Entity, Expr, TaskSpec, Value
from wmspec.lang.check.tables import color_math
from wmspec.lang.check.tables.verbs import VERBS
from wmspec.lang.check.tables.vocabulary import BY_MATERIAL, MAX_LENGTH, PROPERTIES, PropertySpec
from wmspec.lang.check.types.types import A_LENGTH, A_TIME, POINT2, POINT3
from wmspec.lang.check.types.units import LENGTH, format_quantity
from wmspec.sim.materials import MATERIALS

T = TypeVar("T")

#: Properties that a part inherits from its object.
INHERITED = ("color", "material", "image", "repeats", "roughness", "metallic")
#: Properties of an action with objects that must be present: what it acts on, and what that passes through.
ACTED_ON = ("object", "through")
#: Default gravity, m/s².
EARTH_GRAVITY = 9.81
_LENGTHS = frozenset((A_LENGTH, POINT2, POINT3))
_MOMENT = PropertySpec((A_TIME,), "", least=0)


class Evaluator:
    """An environment for `evaluate` without measurements: the design's side of the language.

    `change` is the counterfactual to apply, if any; leaving out an object or action changes no other value. `own` are
    the levels without it. `key` is the prefix of random draws, used for scattered
    objects.
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
        self._removes = change is not None and change.change == "without"
        self._lets = {let.name: let for let in spec.lets}
        self._things = {t.name: t for t in spec.things}
        self._known: dict[tuple[str, str], Any] = {}
        self._open: set[tuple[str, str]] = set()

    @cached_property
    def truth(self) -> Evaluator:
        """The same values without the counterfactual."""
        return Evaluator(self.spec, self.own, None, self.key) if self.change else self

    # ------------------------------------------------------------ the environment

    def ref(self, name: str) -> Any:
        """Return a factor, nuisance or `let`, or `end`, the end of the episode."""
        if name in self.assignment:
            return self.assignment[name]
        if self._removes:
            return self.truth.ref(name)
        return self.memoized(("", name), lambda: self._named(name))

    def during(self, time: float) -> bool:
        """Whether a time (s) is within the episode."""
        return -1e-9 <= time <= self.end + 1e-9

    def property(self, owner: str, name: str) -> object:
        """Return a property or argument of any type. Raises WmsError with its location if it is invalid."""
        if self._removes:
            return self.truth.property(owner, name)
        key = (owner, name)
        if key in self._known:
            return self._known[key]
        setting = self._things[owner].properties.get(name)
        if setting is None or owner in self._changed or not isinstance(setting.value, Value):
            return self.memoized(key, lambda: self._value(owner, name))
        constant = setting.value.value  # fast path for constants
        self._check(self._things[owner], name, constant, setting.place)
        self._known[key] = constant
        return constant

    # Typed accessors. The checker guarantees the types, so a TypeError here is a bug in wmspec.

    def number(self, owner: str, name: str) -> float:
        """Return a numeric property, in SI units."""
        value = self.property(owner, name)
        if isinstance(value, float):
            return value
        if isinstance(value, int) and not isinstance(value, bool):
            return float(value)
        raise _mismatch(owner, name, value, "a number")

    def flag(self, owner: str, name: str) -> bool:
        """Return a boolean property."""
        value = self.property(owner, name)
        if isinstance(value, bool):
            return value
        raise _mismatch(owner, name, value, "true or false")

    def text(self, owner: str, name: str) -> str:
        """Return a property that is a text, or a word of a vocabulary such as a shape or a colour."""
        value = self.property(owner, name)
        if isinstance(value, str):
            return value
        raise _mismatch(owner, name, value, "a text")

    def reference(self, owner: str, name: str) -> str:
        """Return the name of the entity that a property refers to."""
        value = self.property(owner, name)
        if isinstance(value, str):
            return value
        raise _mismatch(owner, name, value, "the name of an entity")

    def references(self, owner: str, name: str) -> tuple[str, ...]:
        """Return the names of the entities that a property refers to."""
        value = self.property(owner, name)
        if isinstance(value, tuple) and all(isinstance(each, str) for each in value):
            return value
        raise _mismatch(owner, name, value, "names of entities")

    def pair(self, owner: str, name: str) -> tuple[float, float]:
        """Return a property with two numbers, in SI units."""
        value = self.property(owner, name)
        if isinstance(value, tuple) and len(value) == 2:
            return value
        raise _mismatch(owner, name, value, "two numbers")

    def vector(self, owner: str, name: str) -> Vector:
        """Return a property with three numbers, in SI units."""
        value = self.property(owner, name)
        if isinstance(value, tuple) and len(value) == 3:
            return value
        raise _mismatch(owner, name, value, "three numbers")

    def points(self, owner: str, name: str) -> tuple[tuple[float, ...], ...]:
        """Return a property that is a list of pairs or vectors, in SI units."""
        value = self.property(owner, name)
        if isinstance(value, tuple) and all(isinstance(each, tuple) for each in value):
            return value
        raise _mismatch(owner, name, value, "a list of points")

    def spot(self, owner: str, name: str = "at") -> Spot:
        """Return a property that is a point or a place on the ground."""
        value = self.property(owner, name)
        if isinstance(value, tuple) and 2 <= len(value) <= 3:
            return value
        raise _mismatch(owner, name, value, "a place")

    def direction(self, owner: str, name: str = "direction") -> float | str:
        """Return a property that is a heading: an angle (rad), or a word such as `left`."""
        value = self.property(owner, name)
        if isinstance(value, float | int | str):
            return value
        raise _mismatch(owner, name, value, "a direction")

    def call(self, function: str, arguments: tuple[Any, ...], **options: Any) -> Any:
        """Return the value of a design function."""
        return functions.call(self, function, arguments, options)

    def memoized(self, key: tuple[str, str], make: Callable[[], T]) -> T:
        """Return the cached value of `make`; `key` is its owner and name. Raises WmsError if it depends on itself."""
        if key not in self._known:
            owner, name = key
            if key in self._open:
                named = f"{owner}.{name}" if owner else name
                raise ImpossibleValue(f"`{named}` depends on itself", self.source_location(owner) if owner else None)
            self._open.add(key)
            try:
                self._known[key] = make()
            finally:
                self._open.discard(key)
        return cast(T, self._known[key])

    # ------------------------------------------------------------ what there is

    def has(self, owner: str, name: str) -> bool:
        """Whether a property is set by the spec, its default, the counterfactual, or for a part by its object."""
        thing, change = self._things[owner], self.change
        if name in thing.properties or (change and (change.owner, change.property) == (owner, name)):
            return True
        return thing.kind == "part" and name in INHERITED and self.has(thing.of, name)

    def source_location(self, owner: str, name: str = "") -> Location:
        """Return the source location of an entity or of one of its properties."""
        thing = self._things[owner]
        return thing.properties[name].place if name in thing.properties else thing.place

    def parts(self, owner: str) -> tuple[str, ...]:
        """Return the names of an object's parts, such as `rack.left`."""
        return self._parts.get(owner, ())

    def is_present(self, name: str) -> bool:
        """Whether an object or action is present.

        An action needs its condition, its object and what that goes through, and a counterfactual may omit it.
        """
        thing = self._things[name]
        if thing.kind == "action":
            about = self.change is not None and self.change.owner == name
            happens = about if thing.added else not (about and self._removes)
            happens = happens and ("when" not in thing.properties or self.flag(name, "when"))
            needed = [role for role in ACTED_ON if role in thing.properties]
            return happens and all(self.is_present(self.reference(name, role)) for role in needed)
        if self._removes and self.change is not None and self.change.owner in (name, thing.of):
            return False  # the object, or the asset with its links and joints
        return "present" not in thing.properties or self.flag(name, "present")

    def under(self, change: Counterfactual) -> Evaluator:
        """Return the values with one change. Raises Unchanged if it equals the instance."""
        if change.change == "levels" and all(self.own[name] == level for name, level in change.levels.items()):
            levels = ", ".join(change.levels)
            raise Unchanged(f"the instance has this level of {levels} itself, so `{change.name}` changes nothing")
        if change.change == "without" and not self.is_present(change.owner):
            raise Unchanged(f"`{change.owner}` is not there, so `{change.name}` changes nothing")
        return Evaluator(self.spec, self.own, change, self.key)

    def ends(self, joint: str) -> tuple[str, ...]:
        """Return the objects that a joint connects: two, or one that it connects to the world."""
        return tuple(self.reference(joint, end) for end in ("of", "to") if self.has(joint, end))

    def actions_on(self, verb: str, owner: str) -> list[Entity]:
        """Return the actions of a verb on an object."""
        return [
            a
            for a in self._actions.get(verb, ())
            if self.reference(a.name, "object") == owner and self.is_present(a.name)
        ]

    @cached_property
    def _parts(self) -> dict[str, tuple[str, ...]]:
        parts: dict[str, tuple[str, ...]] = {}
        for thing in self.spec.things:
            if thing.kind == "part":
                parts[thing.of] = (*parts.get(thing.of, ()), thing.name)
        return parts

    @cached_property
    def assets(self) -> dict[str, tuple[Entity, ...]]:
        """Links and joints of every asset without its base, by the name of the base."""
        assets: dict[str, tuple[Entity, ...]] = {}
        for thing in self.spec.things:
            if thing.kind in ("object", "joint") and thing.of:
                assets[thing.of] = (*assets.get(thing.of, ()), thing)
        return assets

    @cached_property
    def _actions(self) -> dict[str, list[Entity]]:
        """Actions on objects by verb, without those of robots."""
        actions: dict[str, list[Entity]] = {}
        for thing in self.spec.things:
            if thing.kind == "action" and not thing.of:
                actions.setdefault(thing.verb, []).append(thing)
        return actions

    @cached_property
    def world(self) -> str | None:
        """Name of the world, or None if the spec does not declare one."""
        return next((t.name for t in self.spec.things if t.kind == "world"), None)

    @cached_property
    def gravity(self) -> float:
        """Gravitational acceleration, m/s²."""
        return self.number(self.world, "gravity") if self.world else EARTH_GRAVITY

    @cached_property
    def end(self) -> float:
        """End of the episode (s)."""
        return float(self.ref("end"))

    # ------------------------------------------------------------ where things are

    def pose(self, owner: str) -> Pose:
        """Return the initial pose of an object in the world. A supported object touches its support exactly."""
        if self._removes:
            return self.truth.pose(owner)
        return self.memoized((owner, "pose"), lambda: placement.pose(self, owner))

    # ------------------------------------------------------------ working a value out

    def _named(self, name: str) -> Any:
        if name == "end":
            end: float = evaluate(self.spec.horizon, self)
            if end > EPISODE_SECONDS.most:
                place = self.spec.observations[0].place if self.spec.observations else None
                raise ImpossibleValue(f"the episode {EPISODE_SECONDS.sentence} here", place, EPISODE_SECONDS.help)
            return end
        let = self._lets[name]
        return _evaluate(let.value, self, let.place)

    def _value(self, owner: str, name: str) -> Any:
        thing, change = self._things[owner], self.change
        setting = thing.properties.get(name)
        if change is not None and change.change == "order" and name == "start":
            return self._turn(change, owner)
        if change is not None and change.value is not None and (change.owner, change.property) == (owner, name):
            place, value = (
                change.place,
                _evaluate(change.value, self.truth, change.place),
            )  # in terms of the truth
        elif setting is not None:
            place, value = setting.place, _evaluate(setting.value, self, setting.place)
        elif thing.kind == "part" and name in INHERITED and self.has(thing.of, name):
            return self.property(thing.of, name)
        elif name in BY_MATERIAL:
            return self._of_material(owner, name)
        else:
            raise ImpossibleValue(f"`{owner}` has no {name}", thing.place)
        self._check(thing, name, value, place)
        return value

    def _check(self, thing: Entity, name: str, value: Any, place: Location) -> None:
        """Raise WmsError for numbers that are out of bounds."""
        if isinstance(value, str | bool):
            return
        slot = _property_spec(thing, name)
        for number in value if isinstance(value, tuple) else (value,):
            if isinstance(number, float) and (fault := _violation(number, slot)):
                raise ImpossibleValue(f"`{name}` of `{thing.name}` is {fault}", place)

    def _of_material(self, owner: str, name: str) -> Any:
        """Return a property derived from an object's material; an image keeps its own colours."""
        if name != "color":
            return getattr(MATERIALS[self.text(owner, "material")], name)
        return color_math.color_word(
            (1.0, 1.0, 1.0) if self.has(owner, "image") else MATERIALS[self.text(owner, "material")].color
        )

    def _turn(self, change: Counterfactual, owner: str) -> Any:
        """Return the start of an action under a counterfactual that swaps the order of two; others keep theirs.

        The later one takes the start of the earlier one, which then ends when the later one would have.
        """
        start = self.truth.number(owner, "start")
        if owner not in (change.owner, change.property):
            return start
        early, late = sorted((change.owner, change.property), key=lambda a: self.truth.number(a, "start"))
        first, second = self.truth.number(early, "start"), self.truth.number(late, "start")
        return first if owner == late else second + self._duration(late) - self._duration(early)

    def _duration(self, action: str) -> float:
        return self.truth.number(action, "duration") if self.has(action, "duration") else 0.0


def _mismatch(owner: str, name: str, value: object, kind: str) -> TypeError:
    return TypeError(f"`{owner}.{name}` is {value!r}, which is not {kind}: read it with the accessor of its kind")


def _evaluate(expr: Expr, values: Evaluator, place: Location) -> Any:
    try:
        return evaluate(expr, values)
    except NoValue as error:
        raise ImpossibleValue(str(error), place) from None


def _violation(number: float, slot: PropertySpec | None) -> str:
    """Return how a number violates its bounds, or an empty string."""
    if slot and (expected := slot.violation(number)):
        return f"{format_quantity(number, slot.dimension)} here; it must be {expected}"
    if not math.isfinite(number):
        return "not finite"
    if abs(number) > MAX_LENGTH and slot and _LENGTHS.intersection(slot.types):
        return f"{format_quantity(number, LENGTH)} here; the most is {format_quantity(MAX_LENGTH, LENGTH)}"
    return ""


def _property_spec(thing: Entity, name: str) -> PropertySpec | None:
    if thing.kind != "action":
        return PROPERTIES[thing.kind].get(name)
    if name in ("start", "duration"):
        return _MOMENT
    return None if thing.of else VERBS[thing.verb].arguments.get(name)
