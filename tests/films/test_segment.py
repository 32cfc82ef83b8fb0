"""Objects are found in frames, also if they touch and have one colour."""

from __future__ import annotations

import numpy as np
import pytest

from tests.films.corrupt import KEEPS, SPOILS, Original
from wmspec.eval.clips.decide import decide
from wmspec.eval.clips.measure import measure
from wmspec.eval.clips.pixels import overlaps
from wmspec.eval.clips.reference import Reference, WholeFilm

SIDE, FRAMES, CONTEXT = 20, 20, 4


def film(upper: int, lower: int) -> WholeFilm:
    """Two red squares, one on the other, which move to the right by `upper` and `lower` pixels a frame."""
    ground = np.random.default_rng(0).integers(90, 130, (120, 200, 1), dtype=np.uint8).repeat(3, axis=2)
    frames, ids = ground[None].repeat(FRAMES, axis=0), np.zeros((FRAMES, 120, 200), np.int16)
    for t in range(FRAMES):
        for body, top, step in ((1, 40, upper), (2, 40 + SIDE, lower)):
            left = 40 + step * max(t - CONTEXT + 2, 0)
            where = t, slice(top, top + SIDE), slice(left, left + SIDE)
            frames[where], ids[where] = (200, 30, 30), body
    return WholeFilm(frames, ids, CONTEXT)


@pytest.fixture(scope="module")
def reference() -> Reference:
    return Reference(12, tuple(film(*steps) for steps in ((4, 0), (0, 4), (0, 0), (4, 4))), (1, 2))


def test_touching_objects_of_one_colour_are_found_apart(reference: Reference) -> None:
    for found, truth in zip(reference.found, reference.object_bits, strict=True):
        assert overlaps(found.bits, truth).mean(axis=1).min() > 0.8


@pytest.mark.parametrize("damage", ["none", "h264 at 38", "blur", "noise", "shrinks", "deforms"])
def test_their_future_is_recognized(damage: str, reference: Reference) -> None:
    for option in range(4):
        measured = measure(KEEPS[damage](Original(reference, option)), reference, option)
        assert decide(measured, reference.rate).choice == option


def test_a_mixture_of_two_futures_is_none(reference: Reference) -> None:
    for option in range(4):
        measured = measure(SPOILS["mixture"](Original(reference, option)), reference, option)
        assert decide(measured, reference.rate).choice is None
