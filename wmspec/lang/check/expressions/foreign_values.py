"""Remedies for values of a wrong type that are written as in other languages: colours, numbers without unit."""

from __future__ import annotations

import re
from collections.abc import Sequence

from wmspec.lang.check.expressions.typed import ZERO, example
from wmspec.lang.check.types.types import Quantity, Type, Word
from wmspec.lang.check.types.units import NUMBER
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.idioms import hexadecimal_color

_HEXADECIMAL = re.compile(r"#([0-9a-fA-F]{6}|[0-9a-fA-F]{3})")
_UNIT = re.compile(r"[\d.]+ ?(.+)")


def remedy(e: s.Expr, expected: Sequence[Type]) -> str:
    """Return the remedy for a value that has none of the expected types; '' for other mistakes."""
    if Word("color") in expected:
        return _color(e)
    quantity = expected[0] if expected else None
    if isinstance(e, s.Number) and e.unit is None and isinstance(quantity, Quantity):
        unit = _UNIT.fullmatch(example(quantity)) if quantity.dimension not in (NUMBER, ZERO) else None
        return f"write its unit, as in `{e.span.text} {unit[1]}`" if unit else ""
    return ""


def _color(e: s.Expr) -> str:
    if isinstance(e, s.Text) and (found := _HEXADECIMAL.fullmatch(e.value)):
        return f"write `{hexadecimal_color(found[1])}`"
    if isinstance(e, s.Items) and len(e.items) == 3:
        return f"write `rgb({', '.join(item.span.text for item in e.items)})`"
    return ""


def shared_unit(items: Sequence[s.Expr]) -> str:
    """Return the remedy for a list of numbers whose last one alone has a unit; '' for other lists."""
    *others, last = items
    if isinstance(last, s.Number) and last.unit and all(isinstance(o, s.Number) and o.unit is None for o in others):
        numbers = ", ".join(f"{item.value:g}" for item in items if isinstance(item, s.Number))
        return f"write `[{numbers}] {last.unit}`"
    return ""
