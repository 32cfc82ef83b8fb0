"""What has properties: blocks and their parts, by the name that the IR knows them by."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property

from wmspec.core.diagnostics import Note, suggestion
from wmspec.core.places import Span
from wmspec.lang.check.tables.property_schema import ThingType, remedy, slots, thing_type, unfit
from wmspec.lang.check.tables.vocabulary import OTHERWISE, Slot
from wmspec.lang.parse import syntax as s


@dataclass(frozen=True)
class Owner:
    """A block or a part: its name in the IR, its type, and the properties as they are written."""

    name: str
    type: ThingType
    written: tuple[s.Property, ...]
    span: Span
    parts: tuple[str, ...] = ()

    @property
    def slots(self) -> dict[str, Slot]:
        """The properties that it can have."""
        return slots(self.type)

    @cached_property
    def said(self) -> dict[str, s.Property]:
        """The written properties by name, of two that are alike the first; `on: X at Y` says `at` too."""
        properties: dict[str, s.Property] = {}
        for p in self.written:
            properties.setdefault(p.name.id, p)
            if p.at is not None:
                properties.setdefault("at", s.Property(s.Name("at", p.at.span), p.at, None, p.span))
        return properties

    @property
    def strange(self) -> bool:
        """Whether something is said that it cannot have: one of its properties may be meant by that."""
        return not self.said.keys() <= {*self.slots, "at"}

    def lacks(self, name: s.Name) -> tuple[str, str, Span, str]:
        """The complaint about a property that it cannot have: code, message, place and remedy."""
        if reason := unfit(self.type, name.id):
            return "WMS203", reason, name.span, remedy(self.type, name.id)
        kind = self.type.kind
        message = f"{'an' if kind == 'object' else 'a'} {kind} has no property `{name.id}`"
        return "WMS203", message, name.span, _meant(name.id, [*self.slots, *self.parts])

    def silent(self, name: s.Name) -> tuple[str, str, Span, str, tuple[Note, ...]]:
        """The complaint about a property that it could have and does not say."""
        notes = (Note(f"`{self.name}` is declared here", self.span),)
        return "WMS206", f"`{self.name}` does not say its {name.id}", name.span, f"add `{name.id}:` to it", notes


def _meant(name: str, known: list[str]) -> str:
    """A property that the name is another word for, or like."""
    other = OTHERWISE.get(name)
    return f"did you mean `{other}`?" if other in known else suggestion(name, known)


def owner(block: s.Block, members: Iterable[str] = ()) -> Owner:
    """A block as an owner of properties; `members` are the links and joints of an asset, for suggestions."""
    written = {p.name.id for p in block.properties}
    model = block.model.id if block.model is not None and block.kind in ("joint", "robot") else ""
    of = thing_type(block.kind, written, model, bool(block.parts), bool(block.whole))
    names = (*members, *(part.name.id for part in block.parts))
    return Owner(block.name.id, of, block.properties, block.name.span, names)


def parts(block: s.Block) -> Iterator[Owner]:
    """The parts of an object as owners of properties."""
    for part in block.parts:
        of = thing_type("part", {p.name.id for p in part.properties})
        yield Owner(f"{block.name.id}.{part.name.id}", of, part.properties, part.name.span)
