"""The function of a measure: `peak` is the greatest height of an object's middle."""

from __future__ import annotations

from wmspec.runtime.questions.observed import Observed


def peak(observed: Observed, name: str) -> float:
    """The largest height (m) of the middle, over the whole episode."""
    return float(observed.track(name)[:, 2].max())
