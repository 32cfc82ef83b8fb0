"""MuJoCo's warnings in words."""

from __future__ import annotations

from collections.abc import Sequence

from wmspec.core.native_output import silence

with silence():
    import mujoco

_WORDS = {
    "INERTIA": "an inertia is nearly singular",
    "CONTACTFULL": "there are more contacts than fit its memory",
    "CNSTRFULL": "there are more constraints than fit its memory",
    "BADQPOS": "positions grow without bound",
    "BADQVEL": "velocities grow without bound",
    "BADQACC": "accelerations grow without bound",
    "BADCTRL": "a drive has no finite target",
}


def warning_text(counts: Sequence[int], time: float) -> str:
    """Return the warnings with a count above 0 in words, and the time (s) of the state."""
    raised = [words for kind, words in _WORDS.items() if counts[int(getattr(mujoco.mjtWarning, f"mjWARN_{kind}"))]]
    return f"MuJoCo gives up at {time:.4g} s: {' and '.join(raised)}"
