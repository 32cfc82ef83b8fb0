"""Evaluates measured functions of the language on an executed episode."""

from __future__ import annotations

import math
from keyword import iskeyword
from pkgutil import resolve_name
from typing import Any

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.core.diagnostics import WmsError
from wmspec.lang.check.tables.functions import FUNCTIONS
from wmspec.lang.check.types.types import POINT3
from wmspec.runtime.questions.observed import Observed


class Measured:
    """The environment of values of the spec and observations of the episode.

    `readings` collects every measured quantity by its call in source form.
    """

    def __init__(self, values: Evaluator, observed: Observed) -> None:
        self.values = values
        self.observed = observed
        self.readings: dict[str, float] = {}

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

    def _read(self, call: str, value: float) -> None:
        if not math.isfinite(value):
            raise WmsError(f"{call} is not finite")
        self.readings[call] = value

    def each(self, function: str, names: tuple[str, ...]) -> dict[str, float]:
        """Return a measure of each body."""
        return {name: float(self.call(function, (name,))) for name in names}
