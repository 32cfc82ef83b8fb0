"""Formats combinations of factors for messages."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from wmspec.compile.design.levels import Level
from wmspec.lang.check.ir.ir import Factor
from wmspec.lang.check.types import units

if TYPE_CHECKING:
    from wmspec.compile.design.design import Design, Instance


def format_levels(factors: Iterable[Factor], values: Mapping[str, Level]) -> str:
    """Return, for example, `tone = red, pace = 0.5 m/s`; factors without a value are omitted."""
    return ", ".join(f"{f.name} = {_format_level(values[f.name], f.unit)}" for f in factors if f.name in values)


def format_instance(design: Design, instance: Instance) -> str:
    """Return the index of an instance, followed by its factors if they are few."""
    where = format_levels(design.factors, instance.factors)
    return f"in instance {instance.index}" + (f" ({where})" if where and len(where) < 60 else "")


def _format_level(value: Level, unit: str) -> str:
    """Return a level with its unit."""
    match value:
        case bool():
            return "true" if value else "false"
        case float():
            return units.format_quantity(value, units.parse_unit(unit)[1])
        case tuple():
            return f"({', '.join(_format_level(x, unit) for x in value)})"
        case _:
            return str(value)
