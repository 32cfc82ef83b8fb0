"""Tolerances for differences between engines."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.lang.check.tables.vocabulary import TOLERANCES
from wmspec.lang.check.types.units import UnknownUnit, convert, parse_unit


@dataclass(frozen=True)
class Tolerances:
    """Permitted differences between two engines, in SI units.

    The defaults follow from errors against analytic solutions (docs/benchmarks/oracles.md): free flight 0.02 mm in 1 s;
    stopping distance of a slid box 0.2 %; speed after a collision of two balls 2.6 % of the speed before; apex of a
    bounce 2.2 % of the drop; creep at rest 0.3 mm; duration of an impact 3 ms. An off-centre push rotates a box by up
    to 10 degrees more in one engine than in another.
    """

    #: Position of a body that has never moved, m.
    rest: float = 0.0005
    #: Position of a moving body before any impact, m per second of motion.
    drift: float = 0.005
    #: After an impact, position per second of motion, as a share of the impact speed (m/s).
    impact: float = 0.03
    #: Time of a first contact, s; struck bodies may also be off by their motion in that time.
    event: float = 0.010
    #: Visible orientation of a body, rad.
    angle: float = 0.1745


#: An example of each of the tolerances, for messages.
_EXAMPLES = {"rest": "1mm", "drift": "1cm/s", "impact": "5%", "event": "20ms", "angle": "15deg"}


def tolerances(settings: Iterable[str], declared: Mapping[str, float] = MappingProxyType({})) -> Tolerances:
    """Return the defaults, overridden by those `declared` in a spec (SI), then by `settings` such as `drift=1cm/s`.

    Raises WmsError with a remedy.
    """
    given: dict[str, float] = {}
    for setting in settings:
        name, _, text = (part.strip() for part in setting.partition("="))
        if name not in TOLERANCES:
            raise WmsError(f"there is no tolerance `{name}`; {suggestion(name, TOLERANCES) or ', '.join(TOLERANCES)}")
        given[name] = _value(name, text)
    return replace(Tolerances(), **{**declared, **given})


def _value(name: str, text: str) -> float:
    dimension, example = TOLERANCES[name].dimension, _EXAMPLES[name]
    number = text.rstrip("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ/%^ ")
    try:
        scale, unit = parse_unit(text[len(number) :].strip())
        value = convert(float(number), scale)
    except (ValueError, UnknownUnit):
        unit, value = dimension, -1.0
    if unit != dimension or not 0 <= value < 1e6:
        raise WmsError(f"--tolerance {name}={text}: expected a {dimension}, such as {name}={example}")
    return value
