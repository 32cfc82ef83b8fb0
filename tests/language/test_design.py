"""Designs: an instance is a pure function of its index, and draws of what they are for."""

from hypothesis import given, settings
from hypothesis import strategies as st

from tests.language.specs import random_spec, task_from
from wmspec.check.ir import TaskSpec
from wmspec.design.design import Design
from wmspec.design.draws import permuted

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


@settings(max_examples=30, deadline=None)
@given(spec=random_spec(), seed=st.integers(0, 9))
def test_index_and_assignment_are_inverse(spec: TaskSpec, seed: int) -> None:
    design = Design(spec, seed)
    for instance in design:
        assert design.index(instance.factors, instance.block) == instance.index


def test_a_huge_design_is_built_at_once() -> None:
    lines = "".join(f"  factor f{i} in 0 .. 9 by 1\n" for i in range(12))
    mass = " + ".join(f"f{i}" for i in range(12))
    scene = f"  object x {{ mass: ({mass} + 1) * 1 g  on: table }}\n  observe front at [0 s]\n"
    spec = task_from(f"use tabletop\ntask t : custom {{\n{lines}{scene}}}\n")
    design = Design(spec)
    assert len(design) == 10**12
    assert design[123_456_789_012].factors == {f"f{i}": float(d) for i, d in enumerate("123456789012")}
    assert len(set(design.sample(100))) == 100


def test_nuisances_are_drawn_by_block_and_name_alone() -> None:
    """Adding, fixing or reordering factors, objects or nuisances leaves every other draw as it was."""
    plain = Design(task_from(SPEC), seed=7)
    changed = (
        SPEC.replace("factor a in [1, 2, 3]", "factor d in [1, 2]\n  nuisance k in 0 .. 1\n  factor a in [3]")
        .replace("nuisance n in 0 .. 1\n  nuisance m in 0 .. 1", "nuisance m in 0 .. 1\n  nuisance n in 0 .. 1")
        .replace("object x", "object y { mass: (d + k) * 1 kg  on: table at (30 cm, 0) }\n  object x")
    )
    other = Design(task_from(changed), seed=7)
    for block in range(3):
        a, b = plain[block * plain.block_size], other[block * other.block_size]
        assert (a.nuisances["n"], a.nuisances["m"]) == (b.nuisances["n"], b.nuisances["m"])
    draws = {plain[b * plain.block_size].nuisances["n"] for b in range(3)}
    assert len(draws) == 3
    assert Design(task_from(SPEC), seed=8)[0].nuisances != plain[0].nuisances


@given(st.integers(1, 300), st.integers(0, 5))
def test_permutations_permute(n: int, seed: int) -> None:
    assert sorted(permuted(i, n, seed) for i in range(n)) == list(range(n))
