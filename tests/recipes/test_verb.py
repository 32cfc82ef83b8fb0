"""The recipe "adding a verb": a function, and a row that names it. The rest follows from the row."""

from __future__ import annotations

import pytest

import wmspec
from tests.engines import ENGINES, installed
from tools.reference import reference
from wmspec.lang.check.tables.verbs import VERBS, Verb
from wmspec.lang.check.tables.vocabulary import PropertySpec
from wmspec.lang.check.types.types import A_LENGTH, OBJECT

ROW = Verb(
    "sends the object straight up",
    {
        "object": PropertySpec((OBJECT,), "what hops"),
        "height": PropertySpec((A_LENGTH,), "how high it rises", above=0, most=10),
    },
    lasts=False,
    author="tests.recipes.hop:hop",
    staged="launch",
)
SPEC = """
use room
task hops : custom {
  factor height in [20, 30] cm
  object ball { shape: sphere  size: 10 cm  restitution: 0  on: floor }
  action up = hop(ball, height: height) at 0.1 s
  horizon 0.8 s
  observe front at [0 s]
}
"""


@pytest.fixture(autouse=True)
def added(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(VERBS, "hop", ROW)


@pytest.mark.engine
@pytest.mark.parametrize("engine", ENGINES)
def test_it_is_executed_in_every_engine(engine: str) -> None:
    installed(engine)
    for one in wmspec.load(text=SPEC):
        heights = one.run(engine)["ball"].position[:, 2]
        assert max(heights) - heights[0] == pytest.approx(one.factors["height"], rel=0.01)


def test_its_arguments_are_checked() -> None:
    with pytest.raises(wmspec.SpecError, match="length"):
        wmspec.load(text=SPEC.replace("height: height)", "height: 2 s)"))
    with pytest.raises(wmspec.SpecError, match="did you mean `hop`"):
        wmspec.load(text=SPEC.replace("hop(ball", "hopp(ball"))


def test_only_the_documented_dependence_of_a_function() -> None:
    """The promise of one factor at a time holds for it as for every verb."""
    small, large = (one.stage() for one in wmspec.load(text=SPEC))
    paths = [a.GetPath() for prim in small.Traverse() for a in prim.GetAttributes()]
    changed = [p.pathString for p in paths if small.GetAttributeAtPath(p).Get() != large.GetAttributeAtPath(p).Get()]
    assert changed == ["/World/Episode/Actions/up.wms:speed"]


def test_reference_lists_it() -> None:
    assert "`hop(object, height)` sends the object straight up.\n" in list(reference())
