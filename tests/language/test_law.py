"""The law of one factor, by diffing stages: nothing moves but what the spec makes depend on the change."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.language.specs import SPECS, random_spec, task_of
from wmspec.check.ir import TaskSpec
from wmspec.design.depend import Dependencies
from wmspec.design.design import Design
from wmspec.stage.diff import diff
from wmspec.stage.document import Document
from wmspec.stage.episode import document
from wmspec.stage.law import violations
from wmspec.stage.layers import compose


def assert_law(spec: TaskSpec, before: Document, after: Document, changed: str) -> None:
    """The documents obey the law, and USD itself sees the same differences between the stages made of them."""
    assert violations(Dependencies(spec), before, after, changed) == ()
    ours = set(before.differing(after))
    for difference in diff(compose(before), compose(after)):
        path = difference.path
        assert path in ours or any(path.startswith((f"{o}.", f"{o}/")) for o in ours), f"USD also sees {path}"


@pytest.mark.parametrize("path", SPECS, ids=lambda p: p.stem)
@settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_neighbours_differ_in_one_factor_alone(path: Path, data: st.DataObject) -> None:
    spec = task_of(path)
    design = Design(spec, seed=data.draw(st.integers(0, 3)))
    index = data.draw(st.integers(0, len(design) - 1))
    factor = data.draw(st.sampled_from([f.name for f in design.factors]))
    here = design[index]
    for other in design.neighbours(index, factor):
        there = design[other]
        assert {k for k in here.values if here.values[k] != there.values[k]} == {factor}
        assert_law(spec, document(spec, here), document(spec, there), factor)


@pytest.mark.parametrize("path", SPECS, ids=lambda p: p.stem)
@settings(max_examples=15, deadline=None)
@given(data=st.data())
def test_a_counterfactual_changes_its_target_alone(path: Path, data: st.DataObject) -> None:
    spec = task_of(path)
    design = Design(spec)
    here = design[data.draw(st.integers(0, len(design) - 1))]
    for question in spec.questions:
        for change in question.counterfactuals:
            truth, altered = document(spec, here), document(spec, here, change)
            assert truth.differing(altered), f"{change.name} changes nothing"
            assert_law(spec, truth, altered, f"{change.owner}.{change.property}")


@settings(max_examples=40, deadline=None)
@given(spec=random_spec(), data=st.data())
def test_the_law_holds_on_random_specs(spec: TaskSpec, data: st.DataObject) -> None:
    design = Design(spec)
    index = data.draw(st.integers(0, len(design) - 1))
    for factor in design.factors:
        for other in design.neighbours(index, factor.name)[:2]:
            assert_law(spec, document(spec, design[index]), document(spec, design[other]), factor.name)


def test_a_property_that_moves_by_itself_is_a_violation() -> None:
    spec = task_of(SPECS[0])
    design = Design(spec)
    before, after = document(spec, design[0]), document(spec, design[design.neighbours(0, "ratio")[0]])
    after.prims["/World/Objects/near"].set("physics:mass", "float", 3.0, "near.mass")
    assert violations(Dependencies(spec), before, after, "ratio") == ("/World/Objects/near.physics:mass",)
