"""Levels of factors and nuisances: their distribution, and their words in messages."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Mapping
from itertools import accumulate
from typing import TYPE_CHECKING

from wmspec.lang.check.ir.ir import Choices, Domain, Factor, Interval, Normal, Scalar
from wmspec.lang.check.types import units

if TYPE_CHECKING:
    from wmspec.compile.design.design import Design, Instance

#: A value of a factor or nuisance: a number, a truth value, a word, or a point.
Level = Scalar | tuple[float, ...]


def quantile(domain: Domain, share: float) -> Level:
    """Return the quantile of a domain at `share` (0 to 1); a uniform share gives a random draw from the domain."""
    match domain:
        case Choices(values=values, weights=None):
            return values[int(share * len(values))]
        case Choices(values=values, weights=tuple(weights)):
            reached = list(accumulate(weights))
            return values[min(bisect_right(reached, share * reached[-1]), len(values) - 1)]
        case Interval(low=low, high=high, logarithmic=True):
            return float(low * (high / low) ** share)
        case Interval(low=low, high=high):
            return low + (high - low) * share
        case Normal(mean=mean, deviation=deviation):
            return mean + deviation * _normal(share)
    raise AssertionError(domain)


def _normal(share: float) -> float:
    """Return the quantile at `share` of the standard normal distribution truncated at ±3."""
    from statistics import NormalDist

    standard = NormalDist()
    tail = standard.cdf(-3.0)
    return standard.inv_cdf(tail + share * (1 - 2 * tail))


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
