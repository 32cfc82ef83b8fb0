"""Equality to the last bit, and where it ends: of types, numbers by their representation, arrays by their bytes."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np


def difference(a: Any, b: Any, where: str = "") -> str:
    """Where two values differ first; empty if nowhere."""
    if type(a) is not type(b):
        return f"{where}: {type(a).__name__} and {type(b).__name__}"
    if is_dataclass(a):
        parts = [(getattr(a, f.name), getattr(b, f.name), f"{where}.{f.name}") for f in fields(a)]
    elif isinstance(a, tuple | list):
        if len(a) != len(b):
            return f"{where}: {len(a)} and {len(b)} of them"
        parts = [(x, y, f"{where}[{i}]") for i, (x, y) in enumerate(zip(a, b, strict=True))]
    elif isinstance(a, np.ndarray):
        alike = (a.dtype, a.shape, a.tobytes()) == (b.dtype, b.shape, b.tobytes())
        return "" if alike else f"{where}: {a} and {b}"
    else:
        return "" if repr(a) == repr(b) else f"{where}: {a!r} and {b!r}"
    return next((d for d in (difference(*part) for part in parts) if d), "")
