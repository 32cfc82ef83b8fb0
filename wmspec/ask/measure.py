"""Measuring on an executed episode: the language's measured functions, as an environment for `evaluate`."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from wmspec.ask import motion, outcome, visibility
from wmspec.ask.observed import Observed
from wmspec.check.functions import FUNCTIONS
from wmspec.diagnostics import WmsError
from wmspec.layout.functions import extreme
from wmspec.layout.values import Values
from wmspec.layout.view import front

#: What an option can say where two are too near to one another to choose.
NEITHER = "neither"


class Measured:
    """The values of the spec together with what was `observed`.

    `readings` collects every quantity that was measured, by its call as a person would write it.
    """

    def __init__(self, values: Values, observed: Observed) -> None:
        self.values = values
        self.observed = observed
        self.readings: dict[str, float] = {}

    def ref(self, name: str) -> Any:
        """A factor, nuisance, `let` or `end`."""
        return self.values.ref(name)

    def property(self, owner: str, name: str) -> Any:
        """A property of the spec, as it was before the episode."""
        return self.values.property(owner, name)

    def call(self, function: str, arguments: tuple[Any, ...]) -> Any:
        """A measured function, or one of the design. An option of a function, if given, is its last argument."""
        if function not in FUNCTIONS or not FUNCTIONS[function].measured:
            return self.values.call(function, arguments)
        if function in CHOICES:
            return CHOICES[function](self, *arguments)
        value = MEASURES[function](self.observed, *arguments)
        if isinstance(value, float | bool):
            if not math.isfinite(value):
                raise WmsError(f"{function} of {', '.join(map(str, arguments))} is not finite")
            self.readings[f"{function}({', '.join(map(str, arguments))})"] = float(value)
        return value

    def each(self, function: str, names: tuple[str, ...]) -> dict[str, float]:
        """A measure of each of the bodies."""
        return {name: float(self.call(function, (name,))) for name in names}


MEASURES: dict[str, Callable[..., Any]] = {
    "speed": motion.speed,
    "moved": motion.moved,
    "onset": motion.onset,
    "moving_time": motion.moving_time,
    "heading": motion.heading,
    "heads_to": motion.heads_to,
    "trajectory": motion.trajectory,
    "displacement": outcome.displacement,
    "distance": outcome.distance,
    "contact": outcome.contact,
    "at_rest": outcome.at_rest,
    "toppled": outcome.toppled,
    "height": outcome.height,
    "contains": outcome.contains,
    "visible": visibility.visible,
    "occluded": visibility.occluded,
    "contrast": visibility.contrast,
    "frame": lambda _, camera, time: (camera, time),
}

# ---------------------------------------------------------------- which of several


def _fastest(measured: Measured, names: tuple[str, ...], tie: float | None = None) -> str:
    return extreme(measured.each("speed", names), True, tie)


def _slowest(measured: Measured, names: tuple[str, ...], tie: float | None = None) -> str:
    return extreme(measured.each("speed", names), False, tie)


def _longest(measured: Measured, names: tuple[str, ...], tie: float | None = None) -> str:
    return extreme(measured.each("moving_time", names), True, tie)


def _mover(measured: Measured, names: tuple[str, ...]) -> str:
    """Speeds compare as distances travelled do: all were observed for the same time."""
    if not any(measured.each("moved", names).values()):
        raise WmsError(f"none of {', '.join(names)} moves, so there is no mover")
    return extreme(measured.each("speed", names), True)


def _first(measured: Measured, names: tuple[str, ...], tie: float | None = None) -> str:
    moving = tuple(name for name, moved in measured.each("moved", names).items() if moved)
    onsets = sorted(measured.each("onset", moving).items(), key=lambda pair: pair[1])
    if not onsets and tie is None:
        raise WmsError(f"none of {', '.join(names)} moves, so none is first")
    if not onsets or (tie is not None and len(onsets) > 1 and onsets[1][1] - onsets[0][1] < tie):
        return NEITHER
    return onsets[0][0]


def _relation(measured: Measured, a: str, b: str) -> str:
    """As the cameras show it."""
    return outcome.relation(measured.observed, a, b, front(measured.values))


CHOICES: dict[str, Callable[..., str]] = {
    "fastest": _fastest,
    "slowest": _slowest,
    "longest": _longest,
    "mover": _mover,
    "first": _first,
    "relation": _relation,
}
