"""Hold-outs: levels and combinations of levels that training never sees, and the splits of a design."""

from pathlib import Path

import pytest

from tests.language.specs import task_from
from wmspec.compile.design.design import Design
from wmspec.core.diagnostics import SpecError, WmsError
from wmspec.core.places import Source
from wmspec.dataset.build.splits import DEFAULT_SHARES, Split, declared_holdouts, parse_split, split_unit
from wmspec.editor.complete import complete
from wmspec.editor.document import Document
from wmspec.lang.check.ir import ir
from wmspec.lang.check.statements.builder import factor, holdout, observe, task, thing
from wmspec.lang.parse.format import format_spec

SPEC = """use tabletop

task t : custom {{
  factor wider in [left, right]
  factor color in [red, blue, green]
  factor away  in [10, 20] cm
  factor room  in [1 called "hall", 2 called "yard"]
  nuisance width in 6 cm .. 9 cm
  {}
  design groups of 60 {{ cross: wider  turn: [color, away] }}

  object a {{ shape: cube  size: if wider == left then width * room else width  color: color  on: table at (0, away) }}
  observe front at [0 s]
  question "Where?" {{
    options [left, right]
    answer  if width > 7 cm then left else right
  }}
}}
"""


def spec(*lines: str) -> ir.TaskSpec:
    return task_from(SPEC.format("\n  ".join(lines)))


def test_levels_are_those_of_the_factors_with_units_and_names() -> None:
    written = spec(
        "holdout color in [green]",
        "holdout (color, away) in [(blue, 20 cm), (red, 0.1 m)]",
        "holdout away in [20] cm",
        'holdout room in ["yard"]',
    )
    assert [(out.factors, out.levels) for out in written.holdouts] == [
        (("color",), (("green",),)),
        (("color", "away"), (("blue", 0.2), ("red", 0.1))),
        (("away",), ((0.2,),)),
        (("room",), ((2.0,),)),
    ]
    assert declared_holdouts(written) == [
        {"color": "green"}, {"color": "blue", "away": 0.2}, {"color": "red", "away": 0.1}, {"away": 0.2},
        {"room": "yard"},
    ]  # fmt: skip
    near: dict[str, bool | float | str | tuple[float, ...]] = {"wider": "left", "away": 0.1, "room": 1.0}
    assert written.is_held_out(near | {"color": "green"})
    assert written.is_held_out(near | {"color": "red"})
    assert not written.is_held_out(near | {"color": "blue"})


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("holdout colour in [green]", "there is no factor `colour`.*did you mean `color`"),
        ("holdout width in [7 cm]", "`width` is a nuisance, and only factors have hold-outs"),
        ("holdout color in [purple]", "`purple` is none of the values of `color`"),
        ("holdout away in [20 m]", "`20 m` is none of the values of `away`"),
        ("holdout away in [20]", "`away` expects a length"),
        ("holdout color in green", "the levels of a hold-out are a list"),
        ("holdout color in []", "this hold-out has no levels"),
        ("holdout color in [red, red]", "`red` is held out twice"),
        ("holdout color in [red]\n  holdout color in [red]", "`red` is held out twice"),
        ("holdout color in [red, blue, green]", "every level of `color` is held out"),
        ("holdout color in [red, blue]\n  holdout color in [green]", "every level of `color` is held out"),
        ("holdout (color, away) in [blue]", "each combination has 2 levels"),
        ("holdout (color, away) in [(blue, 20)] cm", "units of their own"),
        ("holdout (color, color) in [(blue, red)]", "`color` is named twice"),
        ("holdout color.red in [red]", "a hold-out names factors"),
        ("holdout color == green", r"write `holdout color in \[green\]`"),
        ("holdout color x away in [(blue, 20 cm)]", r"write `holdout \(color, away\) in"),
        ("holdout color, away in [(blue, 20 cm)]", r"write `holdout \(color, away\) in"),
    ],
)
def test_a_mistake_is_named_with_its_remedy(line: str, message: str) -> None:
    with pytest.raises(SpecError, match=message):
        spec(*line.split("\n  "))


def test_a_held_out_level_is_no_option_of_a_question() -> None:
    closed = SPEC.replace("cross: wider", "cross: [wider, color]").replace("turn: [color, away]", "turn: [away]")
    closed = closed.replace("options [left, right]", "options orbit of color")
    closed = closed.replace("if width > 7 cm then left else right", "frame(front, end)")
    with pytest.raises(SpecError, match="the options of a question show other levels of `color`"):
        task_from(closed.format("holdout (color, away) in [(green, 20 cm)]"))


def test_a_factor_without_separate_values_has_no_holdout() -> None:
    latin = SPEC.replace("[10, 20] cm", "10 cm .. 20 cm").replace(
        "design groups of 60 {{ cross: wider  turn: [color, away] }}", "design latin of 60"
    )
    with pytest.raises(SpecError, match="`away` has no separate values"):
        task_from(latin.format("holdout away in [10 cm]"))


def test_a_specification_in_python_has_holdouts() -> None:
    parts = (factor("color", ["red", "blue"]), thing("object", "a", shape="cube", size=(0.06,) * 3), observe("c", [0]))
    camera = thing("camera", "c", at=(0, -1, 0.5), look_at=(0, 0, 0))
    assert task("t", *parts, camera, holdout(color="blue")).is_held_out({"color": "blue"})
    for wrong in (holdout(colour="blue"), holdout(color="green")):
        with pytest.raises(WmsError, match="hold-out: "):
            task("t", *parts, camera, wrong)


def test_the_formatter_and_the_editor_know_it() -> None:
    text = SPEC.format("holdout   (color,away)   in [(blue,20 cm)]").replace("{{", "{").replace("}}", "}")
    assert "  holdout (color, away) in [(blue, 20 cm)]\n" in format_spec(Source("t.wms", text))
    written = text.replace("(color,away)", "(col")
    document = Document(Path("t.wms"), written)
    assert "color" in {item.word for item in complete(document, written.index("(col") + 4).offers}


# ---------------------------------------------------------------- splits


def test_splits_divide_the_groups_of_a_design_and_leave_holdouts_to_the_test() -> None:
    written = spec("holdout color in [green]", "holdout (color, away) in [(blue, 20 cm)]")
    design = Design(written, 5)
    parts = {name: set(design.selection(None, allowed=Split(name).contains(design))) for name in DEFAULT_SHARES}
    blocks = {name: {design[index].block for index in part} for name, part in parts.items()}
    assert all(parts.values())
    for one, other in (("train", "validation"), ("train", "test"), ("validation", "test")):
        assert not blocks[one] & blocks[other]
    left = set(range(len(design))) - set[int]().union(*parts.values())
    for index in range(len(design)):
        if index in left:
            assert written.is_held_out(design[index].factors)
            assert design[index].block not in blocks["test"]
        elif index not in parts["test"]:
            assert not written.is_held_out(design[index].factors)
    assert any(written.is_held_out(design[index].factors) for index in parts["test"])
    sampled = design.selection(20, allowed=Split("train").contains(design))
    assert 20 <= len(sampled) <= 26
    assert set(sampled) <= parts["train"]
    shares = [set(design.selection(20, number, 3, Split("train").contains(design))) for number in (1, 2, 3)]
    assert set.union(*shares) == set(sampled)
    assert sum(map(len, shares)) == len(sampled)


def test_groups_that_are_balanced_together_are_in_one_split() -> None:
    balanced = SPEC.replace("{{ cross: wider  turn: [color, away] }}", "{{ cross: wider  turn: color  balance: q }}")
    design = Design(task_from(balanced.replace('question "', 'question q "').format("")), 5)
    inside = Split("train").contains(design)
    for block in range(design.blocks.count):
        batch = design.balance_batch(block)
        assert {split_unit(design, other) for other in batch} == {min(batch)}
        assert len({inside(index) for other in batch for index in design.blocks.members(other)}) == 1


@pytest.mark.parametrize(
    ("name", "shares", "message"),
    [
        ("tset", "", "there is no such split; did you mean `test`"),
        ("", "train=100", "--shares belong to --split"),
        ("test", "train=90,validation=10", "its share is 0 percent"),
        ("test", "train=90,test=20", "add up to 110"),
    ],
)
def test_wrong_splits_are_errors(name: str, shares: str, message: str) -> None:
    with pytest.raises(WmsError, match=message):
        parse_split(name, shares)


def test_a_task_of_one_group_cannot_be_divided(tmp_path: Path) -> None:
    from wmspec.api.generating import plan_dataset

    one = SPEC.replace("  design groups of 60 {{ cross: wider  turn: [color, away] }}\n", "")
    (tmp_path / "t.wms").write_text(one.format(""))
    found = []
    for name in DEFAULT_SHARES:
        try:
            plan_dataset(tmp_path / "t.wms", backend="mujoco", split=name)
        except WmsError as error:
            found.append(str(error))
    assert len(found) == 2
    assert all("one control group" in error and "design groups of N" in error for error in found)
