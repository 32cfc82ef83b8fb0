"""Designs in groups: what is crossed in each, what takes turns, and what is drawn for each group."""

from collections import Counter
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tests.examples import examples
from tests.language.designs import allowed, compare, design_of, random_design
from wmspec.compile.design.design import Design
from wmspec.lang.check.ir.ir import Plan, TaskSpec


def groups(count: int, cross: str = "", turn: str = "") -> Plan:
    return Plan(kind="groups", count=count, cross=tuple(cross), turn=tuple(turn))


@examples(40, 120, deadline=None)
@given(spec=random_design(), count=st.integers(1, 40), seed=st.integers(0, 9), data=st.data())
def test_group_crosses_exactly_its_factors(spec: TaskSpec, count: int, seed: int, data: st.DataObject) -> None:
    everything = list(allowed(spec))
    assume(everything)
    names = data.draw(st.permutations([f.name for f in spec.factors if not f.nuisance]))
    cross = names[: data.draw(st.integers(0, len(names)))]
    turn = names[len(cross) :][: data.draw(st.integers(0, 2))]
    design = Design(replace(spec, repeat=1, plan=groups(count, "".join(cross), "".join(turn))), seed)
    instances = list(design)
    assert [design.index(i.factors, i.block) for i in instances] == list(range(len(design)))
    assert design.draws == count
    turned: list[set[str]] = []
    for block in range(count):
        members = [instances[i] for i in design.blocks.members(block)]
        crossed = {*members[0].crossed}
        assert crossed >= {*cross}
        turned.append(crossed - {*cross})
        fixed = {name: value for name, value in members[0].factors.items() if name not in crossed}
        expected = [c for c in everything if fixed.items() <= c.items()]
        assert sorted(map(repr, (dict(sorted(m.factors.items())) for m in members))) == sorted(map(repr, expected))
        assert len({m.nuisances["n"] for m in members}) == 1
        assert all(m.block == block and m.key == members[0].key for m in members)
    for first in range(0, count, max(1, len(turn))):  # in a round each takes its turn once
        lap = [name for names in turned[first : first + max(1, len(turn))] for name in names]
        assert len(set(lap)) == len(lap) == (min(len(turn), count - first) if turn else 0)
        assert {*lap} <= {*turn}
    sizes = design.sample_sizes
    assert all(sizes[name] == sum(name in names for names in turned) for name in turn)
    drawn = [instances[design.blocks.members(block)[0]].nuisances["n"] for block in range(count)]
    assert len(set(drawn)) == count


@examples(25, 60, deadline=None)
@given(spec=random_design(), count=st.integers(2, 30), data=st.data())
def test_neighbours_are_in_the_group_and_differ_in_one_factor(spec: TaskSpec, count: int, data: st.DataObject) -> None:
    assume(list(allowed(spec)))
    names = [f.name for f in spec.factors if not f.nuisance]
    design = Design(replace(spec, repeat=1, plan=groups(count, names[0], "".join(names[1:]))))
    here = design[data.draw(st.integers(0, len(design) - 1))]
    for factor in here.factors:
        for other in design.neighbours(here.index, factor):
            there = design[other]
            assert there.block == here.block
            assert [n for n in here.values if here.values[n] != there.values[n]] == [factor]
        assert factor in here.crossed or not design.neighbours(here.index, factor)


def test_groups_of_a_turn_balance_values() -> None:
    design = Design(design_of({"a": 2, "b": 3, "c": 4, "d": 5}, compare("!=", "c", "d"), plan=groups(240, "a", "bc")))
    firsts = [design[design.blocks.members(block)[0]] for block in range(240)]
    b, c = ([i.factors for i in firsts if name in i.crossed] for name in "bc")
    counts: tuple[Counter[Any], ...] = (
        Counter(i["b"] for i in c),
        Counter(i["d"] for i in c),
        Counter((i["c"], i["d"]) for i in b),  # the allowed pairs
    )
    for often, levels in zip(counts, (3, 5, 16), strict=True):
        assert len(often) == levels
        assert max(often.values()) - min(often.values()) <= 1


def test_more_groups_and_more_factors_move_no_draw() -> None:
    small = design_of({"a": 2, "b": 3, "c": 4}, plan=groups(20, "a", "b"))
    design = Design(small, seed=3)
    longer = Design(replace(small, plan=groups(50, "a", "b")), seed=3)
    wider = Design(design_of({"z": 3, "c": 4, "b": 3, "a": 2}, plan=groups(20, "a", "b")), seed=3)
    for i in range(len(design)):
        assert design[i].values == longer[i].values
        there = wider[i].values
        assert design[i].values == {name: value for name, value in there.items() if name != "z"}


def test_a_sample_is_of_as_many_groups_as_can_be() -> None:
    design = Design(design_of({"a": 4, "b": 3}, plan=groups(30, "a")))
    sampled = design.sample(22)
    assert len(sampled) == 20
    assert Counter(design[i].block for i in sampled) == dict.fromkeys((design[i].block for i in sampled), 4)
    assert len(design.sample(1)) == 4


def test_of_a_group_a_sample_has_all_that_is_crossed_with_one_value_of_what_takes_turns() -> None:
    design = Design(design_of({"a": 4, "b": 3, "c": 2}, plan=groups(30, "a", "bc")))
    first, more = design.sample(120), design.sample(180)
    assert len({design[i].block for i in first}) == 30
    for block in range(30):
        part = [design[i].factors for i in first if design[i].block == block]
        assert sorted(p["a"] for p in part) == [0, 1, 2, 3]
        assert len({(p["b"], p["c"]) for p in part}) == 1
    assert more[:120] == first
    assert max(Counter(design[i].block for i in more).values()) == 8
    assert sorted(design.sample(10_000)) == list(range(len(design)))


@pytest.mark.parametrize("tied", [False, True])
def test_an_instance_of_very_many_groups_is_found_without_the_others(tied: bool) -> None:
    conditions = [compare("!=", "b", "c")] if tied else []
    design = Design(design_of({"a": 4, "b": 3, "c": 3}, *conditions, plan=groups(5_000_000, "a", "b")))
    last = design[len(design) - 1]
    assert last.block == 4_999_999
    assert design.index(last.factors, last.block) == len(design) - 1
