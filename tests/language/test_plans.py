"""Plans: balanced samples, Latin hypercubes, one factor at a time."""

from collections import Counter
from dataclasses import replace
from itertools import combinations

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tests.language.designs import allowed, compare, design_of, random_design
from tests.language.specs import task_from
from wmspec.compile.design.design import Design
from wmspec.compile.design.levels import quantile
from wmspec.core.diagnostics import SpecError
from wmspec.lang.check.ir.ir import Plan, TaskSpec


def sample(count: int) -> Plan:
    return Plan(kind="sample", count=count)


@settings(max_examples=150, deadline=None)
@given(sizes=st.lists(st.integers(1, 7), min_size=1, max_size=5), count=st.integers(1, 300), seed=st.integers(0, 99))
def test_a_sample_is_distinct_and_balanced_to_within_one(sizes: list[int], count: int, seed: int) -> None:
    spec = design_of({f"f{i}": size for i, size in enumerate(sizes)}, plan=sample(count))
    design = Design(spec, seed)
    assert len(design) == min(count, len(Design(design_of({f"f{i}": size for i, size in enumerate(sizes)}))))
    rows = [tuple(i.factors.values()) for i in design]
    assert len(set(rows)) == len(rows)
    for i, size in enumerate(sizes):
        often = Counter(row[i] for row in rows)
        assert max(often.values()) - min(often[float(level)] for level in range(size)) <= 1
    assert [design.index(i.factors) for i in design] == list(range(len(design)))


@settings(max_examples=60, deadline=None)
@given(spec=random_design(), count=st.integers(1, 60), seed=st.integers(0, 9))
def test_a_sample_is_of_what_is_allowed(spec: TaskSpec, count: int, seed: int) -> None:
    everything = list(allowed(spec))
    assume(everything)
    design = Design(replace(spec, plan=sample(count)), seed)
    assert len(design.blocks.members(0)) == min(count, len(everything))
    assert all(i.factors in everything for i in design)
    found = {tuple(i.factors.items()) for i in design}
    assert len(found) == len(design.blocks.members(0))
    for values in everything:
        assert (design.index(values) is not None) == (tuple(values.items()) in found)


def test_tied_factors_are_balanced_as_far_as_conditions_allow() -> None:
    """Of two unlike colours of four, each is as often the first, and as often the second, to within one."""
    for count in (6, 50, 101, 500):
        design = Design(design_of({"a": 4, "b": 4, "c": 3}, compare("!=", "a", "b"), plan=sample(count)))
        for name in "abc":
            often = Counter(i.factors[name] for i in design)
            assert max(often.values()) - min(often.values()) <= 1, (count, name, often)


def test_samples_look_random_in_pairs() -> None:
    """Over many seeds, two factors of a small sample are no more alike than chance makes them."""
    statistic = 0.0
    for seed in range(30):
        design = Design(design_of({f"f{i}": 4 for i in range(8)}, plan=sample(160)), seed)
        for a, b in combinations(("f3", "f5", "f6", "f7"), 2):
            often = Counter((i.factors[a], i.factors[b]) for i in design)
            statistic += sum((often[x, y] - 10) ** 2 / 10 for x in map(float, range(4)) for y in map(float, range(4)))
    # Chi-square with (4 - 1)^2 degrees of freedom: the mean of 180 has a standard deviation of 0.32.
    assert statistic / (30 * 6) == pytest.approx(9, rel=0.16)


def test_the_order_of_statements_does_not_matter_to_a_sample() -> None:
    sizes = {"a": 4, "b": 3, "c": 5, "d": 2, "e": 6}
    one = Design(design_of(sizes, compare("!=", "a", "c"), plan=sample(40)), seed=3)
    other = Design(design_of(dict(reversed(sizes.items())), compare("!=", "a", "c"), plan=sample(40)), seed=3)
    assert {frozenset(i.factors.items()) for i in one} == {frozenset(i.factors.items()) for i in other}


def test_a_sample_of_an_endless_design() -> None:
    design = Design(design_of({f"f{i:02}": 100 for i in range(20)}, plan=sample(1000)))
    rows = [tuple(i.factors.values()) for i in design]
    assert len(set(rows)) == 1000
    assert all(set(Counter(column).values()) == {10} for column in zip(*rows, strict=True))
    assert design.index(design[777].factors) == 777


def test_neighbours_in_a_sample_are_those_in_the_sample() -> None:
    design = Design(design_of({"a": 4, "b": 4, "c": 3}, plan=sample(24)))
    for here in design:
        for name in "abc":
            expected = {
                there.index for there in design if {k for k in "abc" if here.factors[k] != there.factors[k]} == {name}
            }
            assert set(design.neighbours(here.index, name)) == expected


# ---------------------------------------------------------------- Latin hypercubes

LATIN = """
use tabletop
task t : custom {
  factor mass  in log_uniform(10 g, 10 kg)
  factor speed in 1 .. 3 m/s
  factor turn  in normal(0 deg, 10 deg)
  factor tone  in [red, green, blue]
  factor shape in [cube, sphere]
  factor other in if shape == cube then [red, green] else [blue]
  nuisance n in 0 .. 1
  design latin of 50
  repeat 2
  object x { shape: shape  mass: mass + n * 1 g  color: tone  yaw: turn  on: table }
  object y { color: other  on: table at (30 cm, 0 cm) }
  action go = launch(x, direction: turn, speed: speed)
  observe front at [0 s]
}
"""


def test_a_latin_hypercube_has_one_value_in_every_stratum() -> None:
    spec = task_from(LATIN.replace("1 .. 3 m/s", "uniform(1 m/s, 3 m/s)"))
    design = Design(spec, seed=4)
    assert len(design) == 100
    block = design[:50]
    for f in spec.factors[:3]:
        bounds = [quantile(f.domain, i / 50) for i in range(51)]
        values = sorted(i.factors[f.name] for i in block)
        assert all(low <= v <= high for low, v, high in zip(bounds, values, bounds[1:], strict=False))  # type: ignore[operator]
    assert sorted(Counter(i.factors["tone"] for i in block).values()) == [16, 17, 17]
    assert all((i.factors["shape"] == "sphere") == (i.factors["other"] == "blue") for i in block)
    assert [design.index(i.factors, i.block) for i in design] == list(range(100))
    assert design.neighbours(0, "tone") == ()
    assert len({i.nuisances["n"] for i in design}) == 100


# ---------------------------------------------------------------- one factor at a time


def test_one_factor_at_a_time_around_a_baseline() -> None:
    plan = Plan(kind="one_at_a_time", baseline={"b": 2.0})
    spec = design_of({"a": 3, "b": 4, "c": 1}, compare("!=", "a", "b"), plan=plan, repeat=2)
    design = Design(spec)
    baseline = {"a": 0.0, "b": 2.0, "c": 0.0}
    changed = [
        {k: v for k, v in i.factors.items() if v != baseline[k]} for i in design[: len(design.blocks.members(0))]
    ]
    required = [{}, {"a": 1.0}, {"b": 1.0}, {"b": 3.0}]  # a = 2 and b = 0 are excluded
    assert sorted(changed, key=str) == sorted(required, key=str)
    assert len(design) == 8
    at = [next(i for i, other in enumerate(changed) if other == change) for change in required]
    assert set(design.neighbours(at[0], "b")) == {at[2], at[3]}
    assert design.neighbours(at[1], "b") == ()
    with pytest.raises(SpecError, match="a = 0, b = 0, is excluded"):
        Design(replace(spec, plan=Plan(kind="one_at_a_time")))
