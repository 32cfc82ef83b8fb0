"""How far two engines may part and still tell the same story."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace
from types import MappingProxyType

from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.lang.check.types.units import (
    ANGLE,
    LENGTH,
    NUMBER,
    SPEED,
    TIME,
    Dimension,
    UnknownUnit,
    convert,
    parse_unit,
)


@dataclass(frozen=True)
class Tolerances:
    """What two engines may differ by, in SI units.

    The defaults come from measurements of wmspec's own engines, as it sets them up, against analytic answers
    (docs/benchmarks/oracles.md). Their errors: free flight 0.02 mm in 1 s; the stop of a slid box 0.2 % of the way; the
    speed after two balls collide 2.6 % of the speed before; the apex of a bounce 2.2 % of the drop; creep at rest
    0.3 mm; an impact spread over 3 ms. An off-centre push turns a box by up to 10 degrees more in one engine than in
    another.
    """

    #: A body that has never moved, m.
    rest: float = 0.0005
    #: A body in motion that has met nothing yet, m for each second of motion.
    drift: float = 0.005
    #: After an impact, for each second of motion: this share of the speed (m/s) with which the bodies met.
    impact: float = 0.03
    #: The first touch of two bodies, s; and for a body that was met, the way it makes in that time.
    event: float = 0.010
    #: The orientation of a body, as far as it can be seen, rad.
    angle: float = 0.1745


_DIMENSIONS: dict[str, tuple[Dimension, str]] = {
    "rest": (LENGTH, "1mm"),
    "drift": (SPEED, "1cm/s"),
    "impact": (NUMBER, "5%"),
    "event": (TIME, "20ms"),
    "angle": (ANGLE, "15deg"),
}


def tolerances(settings: Iterable[str], declared: Mapping[str, float] = MappingProxyType({})) -> Tolerances:
    """The defaults, in their place what a spec has `declared` (SI), in their place `settings` such as `drift=1cm/s`.

    Raises WmsError with the remedy.
    """
    given: dict[str, float] = {}
    for setting in settings:
        name, _, text = (part.strip() for part in setting.partition("="))
        if name not in _DIMENSIONS:
            known = [f.name for f in fields(Tolerances)]
            raise WmsError(f"there is no tolerance `{name}`; {suggestion(name, known) or ', '.join(known)}")
        given[name] = _value(name, text)
    return replace(Tolerances(), **{**declared, **given})


def _value(name: str, text: str) -> float:
    dimension, example = _DIMENSIONS[name]
    number = text.rstrip("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ/%^ ")
    try:
        scale, unit = parse_unit(text[len(number) :].strip())
        value = convert(float(number), scale)
    except (ValueError, UnknownUnit):
        unit, value = dimension, -1.0
    if unit != dimension or not 0 <= value < 1e6:
        raise WmsError(f"--tolerance {name}={text}: expected a {dimension}, such as {name}={example}")
    return value
