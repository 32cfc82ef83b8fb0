"""The recipe "adding a measure": a function, and a row that names it. The rest follows from the row."""

from __future__ import annotations

import pytest

import wmspec
from tests.engines import installed
from tools.reference import reference
from wmspec.lang.check.tables.functions import FUNCTIONS, Function
from wmspec.lang.check.types.types import A_LENGTH, OBJECT

ROW = Function("the greatest height of its middle", (OBJECT,), A_LENGTH, "tests.recipes.peak:peak")
SPEC = """
use room
task throws : custom {
  factor speed in [1, 2] m/s
  object ball { shape: sphere  size: 10 cm  color: red  on: floor }
  action up = launch(ball, direction: right, climb: 80 deg, speed: speed) at 0.1 s
  horizon 0.5 s
  observe front at [0 s, 0.1 s]
  question "How high does the ball rise?" { answer peak(ball)  within 1 cm  ensure peak(ball) > 6 cm }
}
"""


@pytest.fixture(autouse=True)
def added(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(FUNCTIONS, "peak", ROW)


@pytest.mark.engine
def test_it_is_measured() -> None:
    installed("mujoco")
    for one in wmspec.load(text=SPEC):
        (question,) = one.ask("mujoco", size=128)
        assert question.number is not None
        highest = max(one.run("mujoco")["ball"].position[:, 2])
        assert question.number.value == pytest.approx(highest)
        assert (question.number.unit, question.number.within) == ("m", pytest.approx(0.01))
        assert question.measured["peak(ball)"] == pytest.approx(highest)


def test_it_is_known_to_be_measured() -> None:
    """So a question may use it, and nothing that comes before the episode may depend on it."""
    with pytest.raises(wmspec.SpecError, match="measured"):
        wmspec.load(text=SPEC.replace("horizon 0.5 s", "let high = peak(ball)  horizon 0.5 s"))
    with pytest.raises(wmspec.SpecError, match="did you mean `peak`"):
        wmspec.load(text=SPEC.replace("answer peak", "answer peek"))


def test_reference_lists_it() -> None:
    assert any(line.startswith("| `peak(") and ROW.meaning in line for line in reference())
