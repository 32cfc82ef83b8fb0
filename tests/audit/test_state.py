"""How an object is turned is evidence as far as a picture shows it."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from wmspec.dataset.audit.cases import Case
from wmspec.dataset.audit.state import named_object_states

Turn = tuple[float, float, float, float]
ANGLES = st.floats(-3.1, 3.1)


def product(a: Turn, b: Turn) -> Turn:
    """The product of two quaternions (w, x, y, z)."""
    (w, x, y, z), (p, q, r, s) = a, b
    return (
        w * p - x * q - y * r - z * s,
        w * q + x * p + y * s - z * r,
        w * r - x * s + y * p + z * q,
        w * s + x * r - y * q + z * p,
    )


def about(axis: int, angle: float) -> Turn:
    """The turn by an angle (rad) about a coordinate axis."""
    along = [float(np.sin(angle / 2)) * (k == axis) for k in range(3)]
    return float(np.cos(angle / 2)), along[0], along[1], along[2]


def features(look: str, turn: Turn) -> NDArray[np.float64]:
    """The features of one object of this look."""
    seen = {"picture": 0, "name": "it", "look": look, "across": 0.5, "down": 0.5, "share": 0.01}
    seen |= dict(zip(("qw", "qx", "qy", "qz"), turn, strict=True)) | {"red": 0.9, "green": 0.1, "blue": 0.1}
    return named_object_states([Case({"context_objects": [seen], "option_name": ["it"]}, (b"",), ())], [0])


def differ(look: str, a: Turn, b: Turn) -> bool:
    """Whether the features of two orientations differ by more than rounding."""
    return bool(np.abs(features(look, a) - features(look, b)).max() > 0.015)


@given(ANGLES, ANGLES, ANGLES)
def test_a_turn_about_its_axis_does_not_show_on_what_is_round_and_plain(lean: float, way: float, spin: float) -> None:
    leant = product(about(2, way), about(0, lean))
    spun = product(leant, about(2, spin))
    assert not differ("red plastic cylinder", leant, spun)
    assert not differ("red plastic sphere", leant, spun)


def test_it_shows_on_what_has_a_pattern_or_edges_and_leaning_shows_on_a_cylinder() -> None:
    upright, spun, leant = about(2, 0.0), about(2, 0.7), about(0, 0.7)
    assert differ("red wood cylinder", upright, spun)
    assert differ("red plastic cube", upright, spun)
    assert differ("red plastic cylinder", upright, leant)
    assert not differ("red plastic sphere", upright, leant)
