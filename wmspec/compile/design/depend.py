"""Static dependencies between factors and properties of a spec.

A source is the name of a factor or nuisance, or an `owner.property` of the spec. Some names group several properties:
`ball.pose` (position and orientation), `ball.form` (shape, size and parts), `push.there` (whether the action happens),
`push.way` (the position of its object when it begins).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from wmspec.compile.layout.evaluator import ACTED_ON, INHERITED
from wmspec.compile.layout.motion import PLACING
from wmspec.core.memoize import LRU
from wmspec.lang.check.ir.evaluate import subexpressions
from wmspec.lang.check.ir.ir import Call, Choices, Counterfactual, Entity, Expr, Property, Ref, TaskSpec, Value
from wmspec.lang.check.tables.vocabulary import BY_MATERIAL, MEASURES

#: Properties that determine the form of an object or part.
FORM = ("shape", *MEASURES, "file", "scale", "units", "up", "collision")
_TURN = ("yaw", "pitch", "roll")
#: Properties that determine the position of an object.
PLACEMENT = ("at", "on", "inside", *_TURN)
_SCATTER = ("scatter", "gap")

#: Number of specs whose dependencies are cached.
_MAX_CACHED = 8
_latest: LRU[int, tuple[TaskSpec, Dependencies]] = LRU(_MAX_CACHED)

#: Properties of its objects that a function reads.
_FUNCTION_READS: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("toward", "left_of", "right_of", "in_front_of", "behind", "polar", "between"), ("pose",)),
    **dict.fromkeys(("volume", "largest", "smallest"), ("form",)),
    **dict.fromkeys(("luminance", "darkest", "lightest"), ("color",)),
    **dict.fromkeys(("count", "present"), ("present",)),
    "fits": ("form", "pose"),
}


def dependencies(spec: TaskSpec) -> Dependencies:
    """Return the dependencies of a spec, cached by identity since specs are immutable."""
    return _latest.get(id(spec), lambda: (spec, Dependencies(spec)))[1]  # keeping the spec keeps its `id` unique


class Dependencies:
    """Transitive dependencies within one task, each computed once."""

    def __init__(self, spec: TaskSpec) -> None:
        self._lets = {let.name: let.value for let in spec.lets}
        self._things = {t.name: t for t in spec.things}
        self._domains = {f.name: f.domain for f in spec.factors}
        self._next: dict[str, frozenset[str]] = {"end": self._direct(spec.horizon)}
        self._all: dict[str, frozenset[str]] = {}
        self._expressions: dict[int, tuple[Expr, frozenset[str]]] = {}  # by `id`; keeping them keeps it unique
        for observation in spec.observations:
            name = f"observe.{observation.camera}"
            self._next[name] = self._next.get(name, frozenset()) | self._direct(observation.times)

    def expression(self, expr: Expr) -> frozenset[str]:
        """Return the factors, nuisances and `owner.property`s that an expression depends on."""
        if id(expr) not in self._expressions:
            self._expressions[id(expr)] = expr, self.sources(self._direct(expr))
        return self._expressions[id(expr)][1]

    def sources(self, sources: Iterable[str]) -> frozenset[str]:
        """Return all dependencies of these sources, including themselves."""
        reached: set[str] = set()
        waiting = list(sources)
        while waiting:
            source = waiting.pop()
            if source not in reached:
                reached.add(source)
                if source not in self._next:
                    self._next[source] = self._step(source)
                waiting += self._next[source]
        return frozenset(reached - self._lets.keys())

    def source(self, source: str) -> frozenset[str]:
        """Return all dependencies of a source, including itself."""
        if source not in self._all:
            self._all[source] = self.sources((source,))
        return self._all[source]

    def named(self, expr: Expr) -> frozenset[str]:
        """Return the names of the entities that an expression may refer to."""
        named: set[str] = set()
        for part in subexpressions(expr):
            match part:
                case Value(value=str(name)) if name in self._things:
                    named.add(name)
                case Ref(name=name) if name in self._lets:
                    named |= self.named(self._lets[name])
                case Ref(name=name) if isinstance(domain := self._domains.get(name), Choices):
                    named |= {v for v in domain.values if isinstance(v, str) and v in self._things}
                case Property(owner=owner, name=name):
                    for thing in self.named(owner):
                        if name in self._things[thing].properties:
                            named |= self.named(self._things[thing].properties[name].value)
        return frozenset(named)

    # ------------------------------------------------------------ from one to the next

    def _step(self, source: str) -> frozenset[str]:
        """Return the direct dependencies of a source."""
        if source in self._lets:
            return self._direct(self._lets[source])
        owner, _, name = source.rpartition(".")
        if owner not in self._things:
            return frozenset()
        made_of: set[str] = set()
        for other in self._of_property(self._things[owner], name):
            made_of |= {other} if isinstance(other, str) else self._direct(other)
        return frozenset(made_of)

    def _direct(self, expr: Expr) -> frozenset[str]:
        """Return the sources that an expression names."""
        direct: set[str] = set()
        for part in subexpressions(expr):
            match part:
                case Ref(name=name):
                    direct.add(name)
                case Property(owner=owner, name=name):
                    direct |= {f"{named}.{name}" for named in self.named(owner)}
                case Call(function=function, arguments=arguments, options=options) if function in _FUNCTION_READS:
                    for argument in (*arguments, *(option.value for option in options)):
                        direct |= {
                            f"{n}.{aspect}" for n in self.named(argument) for aspect in _FUNCTION_READS[function]
                        }
        return frozenset(direct)

    # ------------------------------------------------------------ what one property is made of

    def _of_property(self, thing: Entity, name: str) -> Iterator[str | Expr]:
        """Yield the sources and expressions that determine a property of an entity."""
        if name in _COMPOSITE_SOURCES:
            yield from _COMPOSITE_SOURCES[name](self, thing)
        elif name in thing.properties:
            yield thing.properties[name].value
        elif thing.kind == "part" and name in INHERITED:
            yield f"{thing.of}.{name}"
        if name in BY_MATERIAL and name not in thing.properties:
            yield from (f"{thing.name}.material", f"{thing.name}.image")

    def _form(self, thing: Entity) -> Iterator[str]:
        """Yield the sources of an entity's form."""
        placed = ("at", *_TURN, "solid") if thing.kind == "part" else ()
        yield from (f"{thing.name}.{name}" for name in (*FORM, *placed))
        yield from (f"{part.name}.form" for part in self._parts(thing))

    def _pose(self, thing: Entity) -> Iterator[str | Expr]:
        """Yield the sources and expressions of an entity's pose."""
        yield f"{thing.name}.form"
        for near in self._asset(thing):
            turns = ("pose",) if near.name == thing.of else ("start",) if near.kind == "joint" else ("form", *_TURN)
            yield from (f"{near.name}.{name}" for name in turns)
        yield from (f"{thing.name}.{name}" for name in PLACEMENT)
        if thing.kind == "camera":
            yield from (f"{thing.name}.look_at", f"{thing.name}.ride")
            yield from (f"{base}.pose" for base in self._ridden(thing))
        for way in ("on", "inside"):
            if way in thing.properties:
                yield from (f"{base}.pose" for base in self.named(thing.properties[way].value))
        if "scatter" in thing.properties:
            for other in self._things.values():
                if "scatter" in other.properties:
                    yield from (f"{other.name}.{n}" for n in (*_SCATTER, "form", "at", "on", "pitch", "roll"))
        for drop in self._acting(("drop",), thing.name):
            yield from (f"{drop.name}.{name}" for name in ("there", "object", "height"))

    def _ridden(self, camera: Entity) -> frozenset[str]:
        """Return the objects that may carry a camera."""
        return self.named(camera.properties["ride"].value) if "ride" in camera.properties else frozenset()

    def _there(self, action: Entity) -> Iterator[str]:
        """Yield the sources that determine whether an action happens."""
        if "when" in action.properties:
            yield f"{action.name}.when"
        for role in ACTED_ON:
            if role in action.properties:
                yield f"{action.name}.{role}"
                yield from (f"{owner}.present" for owner in self.named(action.properties[role].value))

    def _way(self, action: Entity) -> Iterator[str]:
        """Yield the sources of the pose of an action's object when the action begins."""
        yield f"{action.name}.start"
        if action.of:
            arm = "object" in action.properties
            yield from self._robots() if arm else self._travels(self._things[action.of])
            return
        for owner in self.named(action.properties["object"].value):
            yield f"{owner}.pose"
            for move in self._acting(PLACING, owner):
                yield from (f"{move.name}.{name}" for name in ("there", "yaw", *move.properties))

    def _robots(self) -> Iterator[str]:
        """Yield the sources of the arms' plan: all their actions, handled objects and base poses."""
        yield from ("end", "world.gravity")
        for thing in self._things.values():
            if thing.kind == "robot":
                yield from (f"{thing.name}.{name}" for name in ("on", "at", "yaw", "model"))
                if "on" in thing.properties:
                    yield from (f"{base}.pose" for base in self.named(thing.properties["on"].value))
            if thing.kind == "action" and thing.of:
                yield from (f"{thing.name}.{name}" for name in ("there", "start", *thing.properties))
                if "joint" in thing.properties:
                    yield from (f"{j}.{n}" for j in self.named(thing.properties["joint"].value) for n in ("at", "axis"))
                for name in {"object", "on"} & thing.properties.keys():
                    for owner in self.named(thing.properties[name].value):
                        yield from (f"{owner}.{aspect}" for aspect in ("pose", "form", "mass", "density", "friction"))

    def _travels(self, robot: Entity) -> Iterator[str]:
        """Yield the sources of a vehicle's or walker's plan: start, actions and possible obstacles."""
        yield from (f"{robot.name}.{name}" for name in ("on", "at", "yaw", "roads", "lane", "keeps"))
        for thing in self._things.values():
            if thing.kind == "action" and thing.of == robot.name:
                yield from (f"{thing.name}.{name}" for name in ("there", "start", *thing.properties))
            elif thing.kind == "object":
                yield from (f"{thing.name}.{name}" for name in ("pose", "form", "present", "drawn", "solid"))
            elif thing.kind == "action" and thing.verb in PLACING and not thing.of:
                yield from (f"{thing.name}.{name}" for name in ("there", "object"))

    # ------------------------------------------------------------ who is who

    def _asset(self, thing: Entity) -> Iterator[Entity]:
        """Yield the other links and the joints of a link's asset; for one link or joint, also the base."""
        base = thing.of or thing.name
        for other in self._things.values():
            near = other.kind in ("object", "joint") and base in (other.name, other.of)
            if thing.kind == "object" and near and other.name != thing.name:
                yield other

    def _parts(self, thing: Entity) -> Iterator[Entity]:
        """Yield the parts of an object."""
        return (t for t in self._things.values() if t.kind == "part" and t.of == thing.name)

    def _acting(self, verbs: Iterable[str], owner: str) -> Iterator[Entity]:
        """Yield the actions with these verbs that may apply to an object."""
        for thing in self._things.values():
            acts = thing.kind == "action" and thing.verb in verbs and not thing.of
            if acts and owner in self.named(thing.properties["object"].value):
                yield thing


_COMPOSITE_SOURCES: dict[str, Callable[[Dependencies, Entity], Iterator[str | Expr]]] = {
    "form": Dependencies._form,
    "pose": Dependencies._pose,
    "way": Dependencies._way,
    "there": Dependencies._there,
}


def changed_by(change: Counterfactual) -> tuple[str, ...]:
    """Return the sources that a counterfactual changes: an `owner.property`, presence, or two start times."""
    if change.change == "levels":
        return tuple(change.levels)
    if change.change == "without":
        return (f"{change.owner}.there", f"{change.owner}.present")
    if change.change == "add":
        return (f"{change.owner}.there",)
    if change.change == "order":
        return (f"{change.owner}.start", f"{change.property}.start")
    if change.property == "mass":  # which takes the place of a density
        return (f"{change.owner}.mass", f"{change.owner}.density")
    return (f"{change.owner}.{change.property}",)
