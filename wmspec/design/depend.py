"""Which factors and properties a value depends on, by looking at the spec alone."""

from __future__ import annotations

from wmspec.check.evaluate import parts
from wmspec.check.ir import Call, Expr, Property, Ref, TaskSpec, Value

#: What decides where an object's middle is.
PLACEMENT = ("at", "on", "shape", "size", "radius", "height", "yaw")


class Dependencies:
    """Transitive dependencies within one task, each worked out once."""

    def __init__(self, spec: TaskSpec) -> None:
        self._lets = {let.name: let.value for let in spec.lets}
        self._things = {t.name: t for t in spec.things}
        self._of: dict[str, frozenset[str]] = {"end": frozenset({"end"})}
        self._of["end"] |= self.expression(spec.horizon)
        for observation in spec.observations:
            name = f"observe.{observation.camera}"
            self._of[name] = self._of.get(name, frozenset({name})) | self.expression(observation.times)

    def expression(self, expr: Expr) -> frozenset[str]:
        """The names of the factors and nuisances, and the `owner.property`s, that the value depends on."""
        found: set[str] = set()
        for part in parts(expr):
            match part:
                case Ref(name=name):
                    found |= self._name(name)
                case Property(owner=Value(value=owner), name=name):
                    found |= self.source(f"{owner}.{name}")
                case Property(name=name):
                    for thing in self._things.values():
                        found |= self.source(f"{thing.name}.{name}")
                case Call(function="toward", arguments=objects):
                    for obj in objects:
                        if isinstance(obj, Value):
                            found |= self.placement(str(obj.value))
        return frozenset(found)

    def _name(self, name: str) -> frozenset[str]:
        if name == "end":
            return self._of["end"]
        if name in self._lets:
            if name not in self._of:
                self._of[name] = self.expression(self._lets[name])
            return self._of[name]
        return frozenset({name})

    def source(self, source: str) -> frozenset[str]:
        """What `owner.property` depends on, itself included."""
        if source not in self._of:
            owner, _, name = source.partition(".")
            thing = self._things.get(owner)
            setting = thing.properties.get(name) if thing else None
            self._of[source] = frozenset({source})  # cut short any circle that the checker let pass
            if setting is not None:
                self._of[source] |= self.expression(setting.value)
        return self._of[source]

    def placement(self, owner: str) -> frozenset[str]:
        """What decides where an object is: its own placement and that of what it rests on."""
        found: set[str] = set()
        for name in PLACEMENT:
            found |= self.source(f"{owner}.{name}")
        on = self._things[owner].properties.get("on")
        if on is not None and isinstance(on.value, Value):
            found |= self.placement(str(on.value.value))
        return frozenset(found)
