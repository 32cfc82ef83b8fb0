"""Measuring on an executed episode: the language's measured functions, as an environment for `evaluate`."""

from __future__ import annotations

import math
from pkgutil import resolve_name
from typing import Any

from wmspec.ask.observed import Observed
from wmspec.check.functions import FUNCTIONS
from wmspec.diagnostics import WmsError
from wmspec.layout.values import Values


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
        row = FUNCTIONS.get(function)
        if row is None or not row.measured:
            return self.values.call(function, arguments)
        measure = resolve_name(row.measured)
        if row.chooses:
            return measure(self, *arguments)
        value = measure(self.observed, *arguments)
        if isinstance(value, float | bool):
            if not math.isfinite(value):
                raise WmsError(f"{function} of {', '.join(map(str, arguments))} is not finite")
            self.readings[f"{function}({', '.join(map(str, arguments))})"] = float(value)
        return value

    def each(self, function: str, names: tuple[str, ...]) -> dict[str, float]:
        """A measure of each of the bodies."""
        return {name: float(self.call(function, (name,))) for name in names}
