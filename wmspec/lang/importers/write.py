"""Creates syntax nodes for asset data: numbers with units, points, colours, property references."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from wmspec.core.places import Span
from wmspec.lang.parse import syntax as s


class Writer:
    """Creates expressions located where the spec names the asset's file."""

    def __init__(self, span: Span) -> None:
        self.span = span

    def number(self, value: float, unit: str | None = None) -> s.Expr:
        """Return a quantity."""
        return s.Number(value, unit, self.span)

    def numbers(self, values: Iterable[float], unit: str | None = None) -> s.Expr:
        """Return a pair or triple of quantities."""
        return s.Items("tuple", tuple(self.number(v, unit) for v in values), None, self.span)

    def value(self, value: Any, unit: str | None = None) -> s.Expr:
        """Return a quantity, a point, or a list of points."""
        if not isinstance(value, tuple):
            return self.number(value, unit)
        if not value or not isinstance(value[0], tuple):
            return self.numbers(value, unit)
        return s.Items("list", tuple(self.numbers(one, unit) for one in value), None, self.span)

    def name(self, name: str) -> s.Name:
        """Return a word or a declared name."""
        return s.Name(name, self.span)

    def names(self, names: Iterable[str]) -> s.Expr:
        """Return a list of declared names."""
        return s.Items("list", tuple(map(self.name, names)), None, self.span)

    def of(self, owner: str, name: str) -> s.Expr:
        """Return a property reference."""
        return s.Member(self.name(owner), self.name(name), self.span)

    def color(self, rgb: tuple[float, float, float]) -> s.Expr:
        """Return a colour by its sRGB components."""
        parts = tuple(s.Argument(None, self.number(part), self.span) for part in rgb)
        return s.Call(self.name("rgb"), parts, self.span)

    def times(self, factors: Iterable[float], unit: str, other: s.Expr) -> s.Expr:
        """Return a triple of quantities, each multiplied by an expression."""
        made = (s.Operation("*", (self.number(f, unit), other), self.span) for f in factors)
        return s.Items("tuple", tuple(made), None, self.span)

    def truth(self, value: bool) -> s.Expr:
        """Return true or false."""
        return s.Truth(value, self.span)

    def text(self, value: str) -> s.Expr:
        """Return a text."""
        return s.Text(value, self.span)

    def properties(self, values: dict[str, s.Expr]) -> tuple[s.Property, ...]:
        """Return properties by name."""
        return tuple(s.Property(self.name(name), value, None, self.span) for name, value in values.items())
