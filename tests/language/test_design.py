"""Designs: an instance is a pure function of its index, and only combinations that conditions allow have one."""

from dataclasses import replace
from itertools import combinations, pairwise

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tests.examples import examples
from tests.language.designs import allowed, compare, design_of, random_design
from tests.language.specs import random_spec, task_from
from wmspec.compile.design.design import Design
from wmspec.core.diagnostics import SpecError
from wmspec.lang.check.ir.ir import Plan, TaskSpec

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


def test_the_design_is_the_allowed_product() -> None:
    design = Design(task_from(SPEC))
    assert len(design) == 3 * (3 * 3 - 3) * 2
    seen = [(*i.factors.values(), i.block) for i in design]
    assert len(set(seen)) == len(seen)
    assert all(i.factors["a"] != i.factors["c"] for i in design)


@examples(60, 150, deadline=None)
@given(spec=random_design())
def test_counting_finds_what_trying_finds(spec: TaskSpec) -> None:
    """Numbering by counts gives each allowed combination once, and its index back."""
    expected = list(allowed(spec))
    if not expected:
        with pytest.raises(SpecError, match="no "):
            Design(spec)
        return
    design = Design(spec)
    found = [i.factors for i in design]
    assert sorted(found, key=str) == sorted(expected * spec.repeat, key=str)
    assert [design.index(i.factors, i.block) for i in design] == list(range(len(design)))


@examples(10, 30, deadline=None)
@given(spec=random_spec(), seed=st.integers(0, 9))
def test_index_and_assignment_are_inverse(spec: TaskSpec, seed: int) -> None:
    design = Design(spec, seed)
    for instance in design:
        assert design.index(instance.factors, instance.block) == instance.index


def test_excluded_combinations_have_no_index() -> None:
    design = Design(design_of({"a": 3, "b": 3}, compare("!=", "a", "b")))
    assert design.index({"a": 1.0, "b": 1.0}) is None
    assert design.index({"a": 7.0, "b": 1.0}) is None


def test_a_huge_design_is_built_at_once() -> None:
    design = Design(design_of({f"f{i:02}": 10 for i in range(12)}))
    assert len(design) == 10**12
    values = [float(d) for d in "123456789012"]
    index = design.index({f.name: value for f, value in zip(design.factors, values, strict=True)})
    assert index is not None
    assert list(design[index].factors.values()) == values
    assert len(set(design.sample(100))) == 100


def test_a_chain_of_conditions_is_counted_without_trying_all() -> None:
    """Twelve factors, each unlike the next: 10 * 9^11 combinations, and in a ring 9^12 + 9 (its chromatic number)."""
    sizes = {f"f{i:02}": 10 for i in range(12)}
    names = list(sizes)
    chain = [compare("!=", a, b) for a, b in pairwise(names)]
    design = Design(design_of(sizes, *chain))
    assert len(design) == 10 * 9**11
    assert len(Design(design_of(sizes, *chain, compare("!=", names[0], names[-1])))) == 9**12 + 9
    for index in (0, 123_456_789, len(design) - 1):
        values = list(design[index].factors.values())
        assert all(a != b for a, b in pairwise(values))
        assert design.index(design[index].factors) == index


def test_an_order_is_found_where_that_of_the_spec_is_too_costly() -> None:
    """The first factor tied to all others: they are eliminated before it, though it is written last."""
    sizes = {**{f"f{i}": 30 for i in range(6)}, "hub": 30}
    spokes = [compare("!=", f"f{i}", "hub") for i in range(6)]
    design = Design(design_of(sizes, *spokes))
    assert len(design) == 30 * 29**6
    here = design[987_654_321]
    assert all(here.factors[f"f{i}"] != here.factors["hub"] for i in range(6))
    assert design.index(here.factors) == 987_654_321


def test_too_much_to_try_or_to_number_is_refused() -> None:
    with pytest.raises(SpecError, match=r"100,000,000 combinations .* 300,000 are the most"):
        Design(design_of(dict.fromkeys("abcd", 100), *(compare("!=", *pair) for pair in combinations("abcd", 2))))
    with pytest.raises(SpecError, match="more than can be numbered"):
        Design(design_of({f"f{i}": 1000 for i in range(7)}))
    assert len(Design(design_of({f"f{i}": 1000 for i in range(7)}, plan=Plan(kind="sample", count=10)))) == 10


# ---------------------------------------------------------------- conditions that leave nothing


@examples(60, 150, deadline=None)
@given(spec=random_design())
def test_the_fewest_conflicting_conditions_are_named(spec: TaskSpec) -> None:
    assume(not list(allowed(spec)))
    with pytest.raises(SpecError) as caught:
        Design(spec)
    (fault,) = caught.value.diagnostics
    assert fault.code == "WMS402"
    named = {int(part) for part in fault.message.split("`")[1::2]}

    def empty(which: set[int]) -> bool:
        kept = tuple(r for i, r in enumerate(spec.requires) if i in which)
        return not list(allowed(replace(spec, requires=kept)))

    assert empty(named)
    fewer = (set(s) for s in combinations(range(len(spec.requires)), len(named) - 1))
    assert not any(empty(which) for which in fewer)
    assert len(fault.notes) == len(named) - 1


# ---------------------------------------------------------------- parts of a design


def test_slices_and_shards_are_lazy_and_make_up_the_whole() -> None:
    design = Design(design_of({f"f{i}": 10 for i in range(12)}))
    part = design[10**11 : 10**11 + 5]
    assert [i.index for i in part] == list(range(10**11, 10**11 + 5))
    assert part[-1].index == 10**11 + 4
    assert [i.index for i in part[1:4:2]] == [10**11 + 1, 10**11 + 3]
    assert sum(len(design.shard(n, 7)) for n in range(1, 8)) == 10**12
    small = Design(design_of({"a": 10}))
    assert [i.index for n in range(1, 4) for i in small.shard(n, 3)] == list(range(10))
    for number in (0, 4):
        with pytest.raises(IndexError):
            small.shard(number, 3)
