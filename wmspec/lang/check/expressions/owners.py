"""Owners of properties: blocks and their parts, by IR name."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property

from wmspec.core.diagnostics import Note, suggestion
from wmspec.core.places import Span
from wmspec.lang.check.tables.property_schema import (
    EntityType,
    allowed_properties,
    entity_type,
    exclusion_reason,
    remedy,
)
from wmspec.lang.check.tables.vocabulary import NOT_RIGID, PROPERTY_ALIASES, RIGID_REMEDY, PropertySpec
from wmspec.lang.parse import syntax as s


@dataclass(frozen=True)
class Owner:
    """A block or part: its IR name, its type, and its written properties."""

    name: str
    type: EntityType
    written: tuple[s.Property, ...]
    span: Span
    parts: tuple[str, ...] = ()

    @property
    def slots(self) -> dict[str, PropertySpec]:
        """The properties that it can have."""
        return allowed_properties(self.type)

    @cached_property
    def set_properties(self) -> dict[str, s.Property]:
        """The written properties by name, of duplicates the first; `on: X at Y` includes `at`."""
        properties: dict[str, s.Property] = {}
        for p in self.written:
            properties.setdefault(p.name.id, p)
            if p.at is not None:
                properties.setdefault("at", s.Property(s.Name("at", p.at.span), p.at, None, p.span))
        return properties

    @property
    def has_unknown_property(self) -> bool:
        """Whether it has a property that is not allowed: it may be a misspelled one."""
        return not self.set_properties.keys() <= {*self.slots, "at"}

    def unknown_property_error(self, name: s.Name) -> tuple[str, str, Span, str]:
        """Return the error about a property that is not allowed: code, message, span and remedy."""
        if reason := exclusion_reason(self.type, name.id):
            return "WMS203", reason, name.span, remedy(self.type, name.id)
        kind = self.type.kind
        message = f"{'an' if kind == 'object' else 'a'} {kind} has no property `{name.id}`"
        return "WMS203", message, name.span, _suggest(name.id, [*self.slots, *self.parts])

    def missing_value_error(self, name: s.Name) -> tuple[str, str, Span, str, tuple[Note, ...]]:
        """Return the error about an allowed property that has no value: code, message, span, remedy and notes."""
        notes = (Note(f"`{self.name}` is declared here", self.span),)
        return "WMS206", f"`{self.name}` has no {name.id}", name.span, f"add `{name.id}:` to it", notes


def _suggest(name: str, known: list[str]) -> str:
    """Return a suggestion for a property: its alias or the most similar name."""
    if name in NOT_RIGID:
        return RIGID_REMEDY
    other = PROPERTY_ALIASES.get(name)
    return f"did you mean `{other}`?" if other in known else suggestion(name, known)


def owner(block: s.Block, members: Iterable[str] = ()) -> Owner:
    """Return a block as an owner; `members` are the links and joints of an asset, for suggestions."""
    written = {p.name.id for p in block.properties}
    model = block.model.id if block.model is not None and block.kind in ("joint", "robot") else ""
    of = entity_type(block.kind, written, model, bool(block.parts), bool(block.whole))
    names = (*members, *(part.name.id for part in block.parts))
    return Owner(block.name.id, of, block.properties, block.name.span, names)


def part_owners(block: s.Block) -> Iterator[Owner]:
    """Yield the parts of an object as owners."""
    for part in block.parts:
        of = entity_type("part", {p.name.id for p in part.properties})
        yield Owner(f"{block.name.id}.{part.name.id}", of, part.properties, part.name.span)
