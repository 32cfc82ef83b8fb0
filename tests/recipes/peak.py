"""The function of a measure: `peak` is how high an object's middle ever is."""

from __future__ import annotations

from wmspec.runtime.questions.observed import Observed


def peak(observed: Observed, name: str) -> float:
    """The largest height (m) of the middle, over the whole episode."""
    return float(observed.track(name)[:, 2].max())
