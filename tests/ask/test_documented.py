"""The numbers in the page on questions are those of the code."""

import math
from pathlib import Path

import pytest

from wmspec.cli.trial import REMEDIES
from wmspec.compile.lint import overlap
from wmspec.dataset.build.card import REASONS
from wmspec.lang.check.tables.functions import FUNCTIONS
from wmspec.runtime.questions import observed, outcome, picture_balance, robustness, trajectory
from wmspec.runtime.questions import visibility_gate as gate
from wmspec.runtime.questions.kinds import pictures
from wmspec.runtime.questions.model import FAILED, Reason

PAGE = " ".join((Path(__file__).parents[2] / "docs/questions.md").read_text().split())


@pytest.mark.parametrize(
    "said",
    [
        f"more than {observed.MIN_MOTION * 1000:g} mm from its place",
        f"slower than {observed.STANDSTILL_SPEED * 100:g} cm/s",
        f"during the last {observed.REST_TIME:g} s",
        f"by a factor below {outcome.DIAGONAL_RATIO:g}",
        f"within {trajectory.MIN_DEVIATION * 1000:g} mm or {trajectory.MIN_DEVIATION_SHARE * 100:g} % of its extent",
        f"more than {trajectory.MAX_COUNTERTURN:.0%} of its turning".replace("%", " %"),
        f"more than {math.degrees(trajectory.MIN_CIRCLE):.0f} degrees",
        f"no corner turns by more than {math.degrees(trajectory.SHARP_CORNER):.0f} degrees",
        f"the path turns by more than {math.degrees(trajectory.MIN_ARC):.0f} degrees",
        f"no sphere of more than {overlap.MAX_OVERLAP * 1000:g} mm",
        f"{picture_balance.MIN_DIFFERENT_SHARE * 256**2:.0f} of 256 × 256 pixels show another",
        f"equally near (to {pictures.DISTANCE_TOLERANCE * 1e6:g} micrometre)",
        f"nudges once by {robustness.DEFAULT_NUDGE * 1000:g} mm",
        f"{gate.MIN_VISIBLE_SHARE * 256**2:.0f} of 256 × 256 pixels and a `contrast` of at least {gate.MIN_CONTRAST:g}",
        f"at most {gate.MAX_HIDDEN * 100:.0f} % of this part hidden",
    ],
)
def test_the_page_gives_the_numbers_of_the_code(said: str) -> None:
    assert said in PAGE


def test_the_page_has_every_measure_and_the_card_every_reason() -> None:
    for name, function in FUNCTIONS.items():
        assert not function.measured or name == "frame" or f"`{name}`" in PAGE
    assert set(Reason.__args__) == set(REASONS)  # type: ignore[attr-defined]


def test_every_gate_has_a_remedy() -> None:
    assert set(REMEDIES) == {*REASONS} - FAILED - {"group"}  # a group is rejected with one of its instances
