"""Exact numbers in MJCF."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def text(numbers: ArrayLike) -> str:
    """Return numbers separated by spaces, with all digits."""
    return str(np.ravel(np.asarray(numbers)).tolist())[1:-1].replace(",", "")
