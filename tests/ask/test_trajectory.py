"""The form of a path is that of the verb `follow` that made it, however it lies, with noise on it, whole or thrown."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from wmspec.compile.layout.paths import named_path, rotated_points, timed_points
from wmspec.runtime.questions.trajectory import path_form

FORMS = ("straight", "arc", "zigzag", "circle", "back_and_forth", "square", "triangle")


def path(form: str, length: float, width: float, angle: float, samples: int) -> np.ndarray:
    points, times = timed_points(rotated_points(named_path(form, length, width), angle), 2.0)
    at = np.linspace(0, 2, samples)
    return np.stack([np.interp(at, times, [p[i] for p in points]) for i in range(3)], axis=1)


@given(
    st.sampled_from(FORMS), st.floats(0.1, 1.0), st.floats(0.15, 0.6), st.floats(-3.1, 3.1), st.integers(100, 600),
    st.integers(0, 10**6),
)  # fmt: skip
@example("square", 0.15625, 0.5, 2.5, 100, 100)  # a corner that the noise blunts over 2.6 cm
def test_path_forms_are_recognized_despite_a_millimetre_of_noise(
    name: str, length: float, share: float, angle: float, samples: int, seed: int
) -> None:
    made = path(name, length, max(share * length, 0.04), angle, samples)
    assert path_form(made) == name
    noise = np.random.default_rng(seed).uniform(-0.001, 0.001, made.shape)
    assert path_form(made + noise) == name


@pytest.mark.parametrize("name", sorted({*FORMS} - {"triangle"}))  # of which two corners lie between nine places
def test_a_few_relocations_are_enough(name: str) -> None:
    """The trajectory of an object that teleports between pictures consists of its places."""
    assert path_form(np.repeat(path(name, 0.4, 0.12, 0.3, 9), 60, axis=0)) == name


def test_thrown_object_flies_an_arc() -> None:
    t = np.linspace(0, 0.5, 121)
    assert path_form(np.stack([2 * t, 0 * t, 2.4 * t - 4.905 * t**2], axis=1)) == "arc"


def test_a_single_sharp_corner_has_no_name() -> None:
    t = np.linspace(0, 1, 200)[:, None]
    legs = np.concatenate([t * [0.3, 0, 0], [0.3, 0, 0] + t * [0, 0.3, 0]])
    assert path_form(legs) is None


def test_a_short_rest_before_and_after_changes_nothing() -> None:
    for name in FORMS:
        made = path(name, 0.4, 0.1, 1.0, 300)
        rested = np.concatenate([np.repeat(made[:1], 80, axis=0), made, np.repeat(made[-1:], 80, axis=0)])
        assert path_form(rested) == name
