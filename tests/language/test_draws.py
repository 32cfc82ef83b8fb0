"""Domains and draws: a draw is a pure function of what it is for, and follows its distribution."""

from collections import Counter

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.examples import examples
from tests.language.specs import random_text, task_from
from wmspec.compile.design.design import Design
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.core.rng import Permutation, uniform, uniforms

# ---------------------------------------------------------------- domains


def test_conditional_domains_are_conditions() -> None:
    text = """
    use tabletop
    task t : custom {
      factor shape in [cube, sphere, cone]
      factor tone in if shape == cube then [red, blue] else if shape == sphere then [red, green] else [yellow]
      factor spot in [(10 cm, 0 cm), (0 cm, 10 cm)]
      factor place in product([1 cm, 2 cm], 0 cm .. 4 cm by 2 cm)
      object x { shape: shape  color: tone  on: table at (spot.x, spot.y) }
      object y { size: 2 cm  on: x at place }
      observe front at [0 s]
    }
    """
    design = Design(task_from(text))
    found = {(i.factors["shape"], i.factors["tone"]) for i in design}
    expected = {("cube", "red"), ("cube", "blue"), ("sphere", "red"), ("sphere", "green"), ("cone", "yellow")}
    assert found == expected
    assert len(design) == 5 * 2 * 6
    assert {i.factors["spot"] for i in design} == {(0.1, 0.0), (0.0, 0.1)}
    assert (0.02, 0.04) in {i.factors["place"] for i in design}


def test_nuisances_follow_their_distributions() -> None:
    text = """
    use tabletop
    task t : custom {
      nuisance flat   in uniform(1, 3)
      nuisance log    in log_uniform(1 g, 1 kg)
      nuisance bell   in normal(2 m, 10 cm)
      nuisance uneven in weighted([red, blue], [3, 1])
      repeat 4000
      object x { mass: log  color: uneven  on: table at (bell - 2 m, flat * 1 cm) }
      observe front at [0 s]
    }
    """
    drawn = [i.nuisances for i in Design(task_from(text))]
    flat, log, bell = (sorted(float(d[name]) for d in drawn) for name in ("flat", "log", "bell"))  # type: ignore[arg-type]
    assert flat[2000] == pytest.approx(2, abs=0.06)
    assert log[1000] == pytest.approx(0.001 * 1000**0.25, rel=0.2)
    assert log[3000] == pytest.approx(0.001 * 1000**0.75, rel=0.2)
    assert bell[2000] == pytest.approx(2, abs=0.01)
    assert bell[int(0.8413 * 4000)] == pytest.approx(2.1, abs=0.01)
    assert max(abs(x - 2) for x in bell) <= 0.3
    assert sum(d["uneven"] == "red" for d in drawn) / 4000 == pytest.approx(0.75, abs=0.03)


# ---------------------------------------------------------------- draws

SPEC = """
use tabletop
task t : custom {
  factor a in [1, 2, 3]
  factor b in [red, blue]
  factor c in [1, 2, 3]
  nuisance n in 0 .. 1
  nuisance m in 0 .. 1
  require a != c
  repeat 3
  object x { mass: (a + c + n + m) * 1 kg  color: b  on: table }
  observe front at [0 s]
}
"""

SCATTERED = """
  factor many in [2, 4]
  objects bricks[many] { size: 3 cm  on: table at (0 cm, 20 cm)  scatter: (60 cm, 20 cm)  gap: 1 cm }
  nuisance shift in -2 cm .. 2 cm
"""


@examples(8, 20, deadline=None)
@given(text=random_text() | random_text(grouped=True), data=st.data())
def test_additions_and_reordering_keep_other_draws(text: str, data: st.DataObject) -> None:
    """Whatever happens to the rest of a spec, a draw stays bit by bit what it was."""
    head, _, body = text.partition("custom {\n")
    lines = (body.rpartition("}")[0] + SCATTERED).strip("\n").split("\n")
    more = data.draw(
        st.lists(
            st.sampled_from(
                [
                    "  factor extra in [1, 2, 3]\n  object more { size: extra * 1 cm  on: table at (0, -30 cm) }",
                    "  nuisance aside in 0 cm .. 1 cm\n  object other { size: 1 cm  on: table at (aside, -34 cm) }",
                    "  nuisance loose in normal(0, 1)",
                    "  require many > 1",
                    "  let named = 3",
                    "  repeat 5",
                ]
            ),
            unique=True,
        )
    )
    if "design groups" in text:
        more = [line for line in more if "repeat" not in line]
    changed = data.draw(st.permutations([*lines, *more]))
    variants = iter([line for line in lines if line.startswith("  variant")])  # the first one is the task that is read
    changed = [next(variants) if line.startswith("  variant") else line for line in changed]
    if data.draw(st.booleans()):
        changed = [line.replace("n in [1, 3]", "n in [3]") for line in changed]
    seed = data.draw(st.integers(0, 3))
    before, after = (Design(task_from("\n".join([f"{head}custom {{", *x, "}\n"])), seed) for x in (lines, changed))
    here = before[data.draw(st.integers(0, len(before.blocks.members(0)) - 1))]
    there = after[data.draw(st.integers(0, len(after.blocks.members(0)) - 1))]
    assert here.nuisances.items() <= there.nuisances.items()
    assert _scattered(before, here.index) == _scattered(after, there.index)


def _scattered(design: Design, index: int) -> list[object]:
    instance = design[index]
    values = Evaluator(design.spec, instance.values, None, instance.key)
    return [values.pose(f"bricks_{i}") for i in range(4)]


@given(key=st.lists(st.integers() | st.text(max_size=3), max_size=3), last=st.integers() | st.text(max_size=3))
def test_many_draws_of_a_key_are_its_draws(key: list[object], last: object) -> None:
    draw = uniforms(*key)
    assert draw(last) == draw(last) == uniform(*key, last)


def test_bricks_and_seeds_differ() -> None:
    plain = Design(task_from(SPEC), seed=7)
    draws = {plain[b * len(plain.blocks.members(0))].nuisances["n"] for b in range(3)}
    assert len(draws) == 3
    assert Design(task_from(SPEC), seed=8)[0].nuisances != plain[0].nuisances


@given(st.integers(1, 300), st.integers(0, 5))
def test_permutations_permute(n: int, seed: int) -> None:
    permutation = Permutation(n, seed)
    assert sorted(map(permutation, range(n))) == list(range(n))
    assert [permutation.inverse(permutation(i)) for i in range(n)] == list(range(n))


def test_small_permutations_are_all_as_likely() -> None:
    often = Counter(tuple(map(Permutation(4, seed), range(4))) for seed in range(4800))
    assert len(often) == 24
    assert sum((n - 200) ** 2 / 200 for n in often.values()) < 50  # chi-square, 23 degrees of freedom: 99.9 % is 49.7


ACTING = """
use tabletop
task t : custom {
  factor tone in [red, blue]
  factor way  in ["left", "right"]
  nuisance n in 0 .. 1
  nuisance pace[4] in 10 cm/s .. 20 cm/s
  object x { shape: sphere  size: (n + 4) * 1 cm  color: tone  on: table }
  objects balls[4] { shape: sphere  size: 3 cm  on: table at (0, 20 cm)  scatter: (60 cm, 20 cm)  gap: 1 cm }
  actions go[4] = launch(balls[index], direction: right, speed: pace[index]) at 0.1 s
  observe front at 0 s .. 1 s in 3 frames
  question "Does it move?" { answer moved(x)  may hide balls }
}
"""


@settings(max_examples=6, deadline=None)
@given(
    added=st.lists(
        st.sampled_from(
            [
                (
                    "  nuisance late[2] in 0.2 s .. 0.4 s\n"
                    '  actions halt[2] = stop(balls[index]) at late[index] when way == "left"'
                ),
                "  action gone = vanish(balls[3]) at 0.5 s when tone == red",
                '  question "And without it?" { answer moved(x) without balls[0]  may hide balls }',
                '  question "If it went slowly?" { answer moved(x) under action go[1].speed: 1 cm/s  may hide balls }',
                (
                    "  object y { shape: cube  size: 2 cm  on: table at (0, -30 cm) }\n"
                    'question "Which?" { options [x, y]  answer cause of moved(balls[0]) among [x, y]  may hide balls }'
                ),
            ]
        ),
        unique=True,
        min_size=1,
    ),
    seed=st.integers(0, 3),
)
def test_sets_of_actions_conditions_and_what_ifs_move_no_draw(added: list[str], seed: int) -> None:
    """Draws of members keep every bit, whatever actions and questions are added."""
    head, _, tail = ACTING.rpartition("  observe")
    plain, more = (
        Design(task_from(ACTING), seed),
        Design(task_from("\n".join([head, *added, f"  observe{tail}"])), seed),
    )
    for index in range(len(plain)):
        before, after = plain[index], more[index]
        assert before.factors == after.factors
        assert before.nuisances.items() <= after.nuisances.items()
        own, other = (Evaluator(d.spec, d[index].values, None, d[index].key) for d in (plain, more))
        assert [own.pose(f"balls_{i}") for i in range(4)] == [other.pose(f"balls_{i}") for i in range(4)]
