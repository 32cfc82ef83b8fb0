"""A stage as plain values: prims, attributes, and the spec properties that determine each of them.

Documents can be compared and written without opening a stage, and the one-factor law can be checked on them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from hashlib import blake2b
from typing import Any, NamedTuple

from wmspec.core.canonical import dumps


class Attribute(NamedTuple):
    """A value with its USD type, or a `connection` to another attribute.

    `sources` are the `owner.property`s of the spec that determine it. `varies` is the interpolation of a primvar.
    """

    type: str
    value: Any
    sources: frozenset[str] = frozenset()
    uniform: bool = False
    connection: str = ""
    varies: str = ""


class Relation(NamedTuple):
    """A relationship to prims."""

    targets: tuple[str, ...]
    sources: frozenset[str] = frozenset()


@dataclass
class Prim:
    """A prim under construction: type, applied schemas, and properties in the order of writing.

    `reference` is the referenced file, if any.
    """

    type: str
    schemas: tuple[str, ...] = ()
    attributes: dict[str, Attribute] = field(default_factory=dict)
    relations: dict[str, Relation] = field(default_factory=dict)
    sources: frozenset[str] = frozenset()
    reference: str = ""

    @cached_property
    def digest(self) -> bytes:
        """Return a hash (16 bytes) of its content. The prim must not change afterwards.

        Raises ValueError for a value that is not a number, a text or a list of these.
        """
        return blake2b(self.content, digest_size=16).digest()

    @cached_property
    def targets(self) -> tuple[str, ...]:
        """Return the paths of the prims that it refers to. The prim must not change afterwards."""
        related = (path for relation in self.relations.values() for path in relation.targets)
        plugs = (a.connection.partition(".")[0] for a in self.attributes.values() if a.connection)
        return (*related, *plugs)

    @property
    def content(self) -> bytes:
        """Return its content without sources, as canonical bytes.

        Raises ValueError for a value that is not a number, a text or a list of these.
        """
        attributes = [(n, a.type, a.value, a.uniform, a.connection, a.varies) for n, a in self.attributes.items()]
        relations = [(name, relation.targets) for name, relation in self.relations.items()]
        return dumps((self.type, self.schemas, self.reference, attributes, relations))

    def set(self, name: str, type: str, value: Any, *sources: str, uniform: bool = False, varies: str = "") -> Prim:
        """Add an attribute; returns the prim."""
        self.attributes[name] = Attribute(type, value, frozenset(sources), uniform, varies=varies)
        return self

    def connect(self, name: str, type: str, target: str, *sources: str) -> Prim:
        """Add an attribute connected to another at the path `target`; returns the prim."""
        self.attributes[name] = Attribute(type, None, frozenset(sources), connection=target)
        return self

    def relate(self, name: str, target: str | tuple[str, ...], *sources: str) -> Prim:
        """Add a relationship to one or several prims; returns the prim."""
        targets = (target,) if isinstance(target, str) else target
        self.relations[name] = Relation(targets, frozenset(sources))
        return self


@dataclass(frozen=True)
class Document:
    """Prims by path, parents before children."""

    prims: dict[str, Prim]

    def add(self, path: str, type: str, schemas: Iterable[str] = (), sources: Iterable[str] = ()) -> Prim:
        """Add a prim below its parent, which must exist."""
        prim = Prim(type, tuple(schemas), sources=frozenset(sources))
        self.prims[path] = prim
        return prim

    def differing(self, other: Document) -> dict[str, frozenset[str]]:
        """Return the paths of properties (of prims, for types or whole prims) that differ, with the sources of both
        sides.
        """
        sources: dict[str, frozenset[str]] = {}
        for path in self.prims.keys() | other.prims.keys():
            a, b = self.prims.get(path), other.prims.get(path)
            if a is None or b is None or (a.type, a.schemas, a.reference) != (b.type, b.schemas, b.reference):
                sources[path] = (a.sources if a else frozenset()) | (b.sources if b else frozenset())
            for name in (_names(a) | _names(b)) if a and b else ():
                x, y = _property(a, name), _property(b, name)
                if x is None or y is None or _content(x) != _content(y):
                    sources[f"{path}.{name}"] = (x.sources if x else frozenset()) | (y.sources if y else frozenset())
        return dict(sorted(sources.items()))


def _names(prim: Prim) -> set[str]:
    return prim.attributes.keys() | prim.relations.keys()


def _property(prim: Prim | None, name: str) -> Attribute | Relation | None:
    assert prim is not None
    return prim.attributes.get(name) or prim.relations.get(name)


def _content(prop: Attribute | Relation) -> tuple[Any, ...]:
    return (prop.type, prop.value, prop.connection) if isinstance(prop, Attribute) else prop.targets
