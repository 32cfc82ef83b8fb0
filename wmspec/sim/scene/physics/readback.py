"""Compares settings with the values that an engine reports; engines clamp or ignore some silently."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from wmspec.core.diagnostics import StageError
from wmspec.core.places import PrimPlace


def require_equal(where: str, what: str, got: ArrayLike, expected: ArrayLike, *, tolerance: float = 1e-9) -> None:
    """Raise StageError unless the engine has the `expected` number(s), up to a relative `tolerance`."""
    have, want = np.asarray(got, float), np.asarray(expected, float)
    if np.array_equal(have, want):  # the common case, and faster
        return
    if have.shape != want.shape or not np.allclose(have, want, rtol=tolerance, atol=1e-12):
        message = f"{what} is {want.tolist()} in the scene, but the engine made it {have.tolist()}"
        raise StageError(message, PrimPlace(where))
