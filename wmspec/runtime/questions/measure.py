"""Evaluates measured functions of the language on an executed episode."""

from __future__ import annotations

import math
from collections.abc import Callable
from keyword import iskeyword
from pkgutil import resolve_name
from typing import Any

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.core.diagnostics import WmsError
from wmspec.lang.check.ir.ir import Counterfactual
from wmspec.lang.check.tables.functions import FUNCTIONS
from wmspec.lang.check.types.types import POINT3
from wmspec.runtime.questions.observed import Observed


class Measured:
    """The environment of values of the spec and observations of the episode.

    `readings` collects every measured quantity by its call in source form. `imagine` measures the episode with one
    change.
    """

    def __init__(self, values: Evaluator, observed: Observed, imagine: Callable[[Counterfactual], Measured]) -> None:
        self.values = values
        self.observed = observed
        self.readings: dict[str, float] = {}
        self._imagine = imagine
        self._imagined: dict[str, Measured] = {}

    def ref(self, name: str) -> Any:
        """Return a factor, nuisance, `let` or `end`."""
        return self.values.ref(name)

    def property(self, owner: str, name: str) -> object:
        """Return a property of the spec before the episode."""
        return self.values.property(owner, name)

    def call(self, function: str, arguments: tuple[Any, ...], **options: Any) -> Any:
        """Return the value of a measured function, or of a function of the design."""
        row = FUNCTIONS.get(function)
        if row is None or not row.measured:
            return self.values.call(function, arguments, **options)
        measure = resolve_name(row.measured)
        given = {f"{name}_" if iskeyword(name) else name: value for name, value in options.items()}
        if row.chooses:
            return measure(self, *arguments, **given)
        value = measure(self.observed, *arguments, **given)
        call = f"{function}({', '.join([*map(str, arguments), *(f'{n}: {v:g} s' for n, v in options.items())])})"
        if isinstance(value, float | bool):
            self._read(call, float(value))
        elif row.result == POINT3:
            for axis, part in zip("xyz", value, strict=True):
                self._read(f"{call}.{axis}", part)
        return value

    def under(self, change: Counterfactual) -> Measured:
        """Return the measured values of the episode with one change. Raises Unchanged if it changes nothing."""
        self.values.under(change)
        if change.name not in self._imagined:
            self._imagined[change.name] = self._imagine(change)
        return self._imagined[change.name]

    def all_readings(self) -> dict[str, float]:
        """Return all readings by name, those of changed episodes with the name of the change."""
        imagined = {
            f"{call} under {name}": value
            for name, measured in self._imagined.items()
            for call, value in measured.readings.items()
        }
        return dict(sorted((self.readings | imagined).items()))

    def _read(self, call: str, value: float) -> None:
        if not math.isfinite(value):
            raise WmsError(f"{call} is not finite")
        self.readings[call] = value

    def each(self, function: str, names: tuple[str, ...]) -> dict[str, float]:
        """Return a measure of each body."""
        return {name: float(self.call(function, (name,))) for name in names}
