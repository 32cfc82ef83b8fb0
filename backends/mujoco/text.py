"""Numbers in MJCF, exactly."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def text(numbers: ArrayLike) -> str:
    """Numbers with spaces between them, all their digits given."""
    return str(np.ravel(np.asarray(numbers)).tolist())[1:-1].replace(",", "")
