"""Combinations of factors, as messages tell them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from wmspec.compile.design.levels import Level
from wmspec.lang.check.ir.ir import Factor
from wmspec.lang.check.types import units

if TYPE_CHECKING:
    from wmspec.compile.design.design import Design, Instance


def told(factors: Iterable[Factor], values: Mapping[str, Level]) -> str:
    """Such as `tone = red, pace = 0.5 m/s`, of those factors that have a value."""
    return ", ".join(f"{f.name} = {_shown(values[f.name], f.unit)}" for f in factors if f.name in values)


def told_of(design: Design, instance: Instance) -> str:
    """Which instance that is, with its factors if they are few."""
    where = told(design.factors, instance.factors)
    return f"in instance {instance.index}" + (f" ({where})" if where and len(where) < 60 else "")


def _shown(value: Level, unit: str) -> str:
    match value:
        case bool():
            return "true" if value else "false"
        case float():
            return units.told(value, units.parse_unit(unit)[1])
        case tuple():
            return f"({', '.join(_shown(x, unit) for x in value)})"
        case _:
            return str(value)
