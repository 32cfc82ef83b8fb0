"""Values with units for people."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from wmspec.lang.check.tables.functions import FUNCTIONS
from wmspec.lang.check.types.types import TRUTH, Quantity, Vector

#: SI units with a more readable unit: its sign and scale.
DISPLAY_UNITS = {"m": ("cm", 100.0), "rad": ("°", 180 / math.pi), "kg": ("g", 1000.0), "m/s": ("cm/s", 100.0)}


def format_value(value: Any, unit: str = "") -> str:
    """Return a value in SI units as text: `20 cm/s`, `yes`, `red`, `(10, 20) cm`; a dash for None."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    heavy = unit == "kg" and isinstance(value, float | int) and abs(value) >= 1
    sign, scale = (unit, 1.0) if heavy else DISPLAY_UNITS.get(unit, (unit, 1.0))
    if isinstance(value, Sequence) and not isinstance(value, str):
        return f"({', '.join('–' if v is None else _number(v * scale) for v in value)}){_with_space(sign)}"
    return value if isinstance(value, str) else _number(value * scale) + _with_space(sign)


def _number(value: float) -> str:
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:,.0f}"


def _with_space(sign: str) -> str:
    return sign if sign in ("°", "") else f" {sign}"


def format_reading(name: str, value: float) -> str:
    """Return a measured value in the unit of the measuring function, such as `speed(ball)`."""
    function = FUNCTIONS.get(name.partition("(")[0])
    if function is not None and function.result == TRUTH:
        return format_value(bool(value))
    result = function.result if function is not None else None
    return format_value(value, result.dimension.symbol if isinstance(result, Quantity | Vector) else "")
