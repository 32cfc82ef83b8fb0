"""Levels of factors and nuisances, and their distribution."""

from __future__ import annotations

from bisect import bisect_right
from itertools import accumulate

from wmspec.lang.check.ir.ir import Choices, Domain, Interval, Normal, Scalar

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
