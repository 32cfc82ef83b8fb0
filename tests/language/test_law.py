"""The law of one factor, by diffing stages: nothing moves but what the spec makes depend on the change."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pxr import Usd

from tests.examples import examples
from tests.language.specs import DEEDS, FEW, SPECS, busy_text, random_spec, task_from, task_of
from tests.stage.composed import Difference, diff
from tests.stage.law import violations
from wmspec.compile.design.depend import Dependencies, changed_by, dependencies
from wmspec.compile.design.design import Design
from wmspec.compile.design.what_ifs import what_ifs
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.stage.document import Document
from wmspec.compile.stage.episode import document
from wmspec.compile.stage.layers import base_layer, compose, override_layer
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.lang.check.ir.record import from_json, to_json


def assert_law(spec: TaskSpec, before: Document, stage: Usd.Stage, after: Document, *changed: str) -> None:
    """The documents obey the law, and USD itself sees the same differences between the stages made of them.

    `stage` is composed of `before`: once, for all that it is compared with.
    """
    assert violations(dependencies(spec), before, after, *changed) == ()
    ours = set(before.differing(after))
    for difference in diff(stage, compose(after)):
        path = difference.path.partition("[")[0]
        assert path in ours or any(path.startswith((f"{o}.", f"{o}/")) for o in ours), f"USD also sees {path}"


@pytest.mark.broad
@pytest.mark.parametrize("path", FEW, ids=lambda p: p.stem)
@examples(2, 6)
@given(data=st.data())
def test_neighbours_differ_in_one_factor_alone(path: Path, data: st.DataObject) -> None:
    spec = task_of(path)
    design = Design(spec, seed=data.draw(st.integers(0, 3)))
    index = data.draw(st.integers(0, len(design) - 1))
    factor = data.draw(st.sampled_from([f.name for f in design.factors]))
    here = design[index]
    truth = document(spec, here)
    stage = compose(truth)
    for other in design.neighbours(index, factor):
        there = design[other]
        assert {k for k in here.values if here.values[k] != there.values[k]} == {factor}
        assert_law(spec, truth, stage, document(spec, there), factor)


@pytest.mark.broad
@pytest.mark.parametrize("path", FEW, ids=lambda p: p.stem)
@examples(2, 4)
@given(data=st.data())
def test_a_counterfactual_changes_its_target_alone(path: Path, data: st.DataObject) -> None:
    """Of all changes of an instance the documents show it, and of one the stages made of them, too."""
    spec = task_of(path)
    design = Design(spec)
    here = design[data.draw(st.integers(0, len(design) - 1))]
    names = {thing.name for thing in spec.things}
    truth = document(spec, here)
    values = Evaluator(spec, here.values, None, here.key)
    changes = [c for q in spec.questions for c in (*q.alternatives(here.factors), *what_ifs(q, values))]
    changes = [c for c in changes if c.levels or c.owner in names]
    for change in changes:
        altered = document(spec, here, change)
        assert truth.differing(altered), f"{change.name} changes nothing"
        assert violations(dependencies(spec), truth, altered, *changed_by(change)) == ()
    if changes:
        change = data.draw(st.sampled_from(changes))
        assert_law(spec, truth, compose(truth), document(spec, here, change), *changed_by(change))


@pytest.mark.parametrize("deeds", DEEDS, ids=lambda d: d.partition("(")[0].rpartition(" ")[2])
def test_the_law_holds_whatever_happens(deeds: str) -> None:
    spec = task_from(busy_text(deeds))
    design, depend = Design(spec), Dependencies(spec)
    for index in design.sample(1):
        truth = document(spec, design[index])
        for factor in design.factors:
            for other in design.neighbours(index, factor.name):
                assert violations(depend, truth, document(spec, design[other]), factor.name) == ()
        for change in spec.questions[0].alternatives(design[index].factors):
            assert violations(depend, truth, document(spec, design[index], change), *changed_by(change)) == ()


@examples(5, 30)
@given(spec=random_spec() | random_spec(grouped=True), data=st.data())
def test_the_law_holds_on_random_specs(spec: TaskSpec, data: st.DataObject) -> None:
    redrawn = data.draw(st.integers(0, 2)) if spec.plan.balance else 0
    design, depend = Design(spec).redrawn(redrawn), Dependencies(spec)
    here = design[data.draw(st.integers(0, len(design) - 1))]
    truth = document(spec, here)
    changed: dict[tuple[str, ...], Document] = {
        (f.name,): document(spec, design[i]) for f in design.factors for i in design.neighbours(here.index, f.name)[:1]
    }
    changed |= {changed_by(c): document(spec, here, c) for c in spec.questions[0].alternatives(here.factors)}
    values = Evaluator(spec, here.values, None, here.key)
    imagined = [change for question in spec.questions for change in what_ifs(question, values)]
    changed |= {changed_by(change): document(spec, here, change) for change in imagined}
    for sources, other in changed.items():
        assert violations(depend, truth, other, *sources) == ()
    sources, other = data.draw(st.sampled_from(list(changed.items())))
    assert_law(spec, truth, compose(truth), other, *sources)
    assert made_over(truth, other) == ()


@examples(5, 30)
@given(spec=random_spec(grouped=True), seed=st.integers(0, 3), data=st.data())
def test_a_member_of_a_closed_set_is_its_sibling(spec: TaskSpec, seed: int, data: st.DataObject) -> None:
    """What an instance would be with a sibling's levels is the sibling, to the last property."""
    design = Design(spec, seed).redrawn(data.draw(st.integers(0, 2)))
    here = design[data.draw(st.integers(0, len(design) - 1))]
    changes = spec.questions[0].alternatives(here.factors)
    assert len(changes) + 1 == len(spec.questions[0].counterfactuals)
    for change in changes:
        there = design.index(here.factors | change.levels, here.block)
        assert there is not None
        assert not document(spec, here, change).differing(document(spec, design[there]))


def made_over(before: Document, after: Document) -> tuple[Difference, ...]:
    """How an override of one stage differs from the other, but for prims that it has put aside."""
    base = base_layer(before)
    over = Usd.Stage.Open(override_layer(before, after, base.identifier))
    return tuple(d for d in diff(over, compose(after)) if d.after is not None)


def test_property_without_a_cause_is_a_violation() -> None:
    spec = task_from("""use tabletop
      task one : custom { factor big in [4, 6] cm  object a { size: big  on: table } observe front at [0 s] }""")
    before, after = (document(spec, instance) for instance in Design(spec))
    after.prims["/World/Objects/a"].set("physics:mass", "float", 3.0, "a.mass")
    assert violations(Dependencies(spec), before, after, "big") == ("/World/Objects/a.physics:mass",)


@pytest.mark.broad
@pytest.mark.parametrize("path", SPECS[::7], ids=lambda p: p.stem)
def test_dependencies_are_worked_out_once_for_a_spec(path: Path) -> None:
    spec = task_of(path)
    kept, rebuilt = dependencies(spec), Dependencies(spec)
    assert dependencies(spec) is kept
    assert dependencies(from_json(to_json(spec))) is not kept
    names = [f"{thing.name}.{name}" for thing in spec.things for name in ("pose", "form", *thing.properties)]
    assert kept.sources(names) == frozenset().union(*map(rebuilt.source, names))
    assert all(kept.source(name) == rebuilt.source(name) for name in names)
