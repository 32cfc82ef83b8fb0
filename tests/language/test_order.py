"""The order of a design: without the seed, an index, a group and an id tell nothing about the levels of factors."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from tests.examples import examples, slow_except
from tests.language.designs import compare, design_of
from tests.language.specs import SPECS, task_of
from wmspec.compile.design.design import Design, Instance
from wmspec.core.rng import bits
from wmspec.dataset.build.identity import DIGITS, identity
from wmspec.lang.check.ir.ir import Plan, TaskSpec
from wmspec.runtime.questions.ask import groups

#: Probability at which one of all tests in this file fails although nothing leaks.
ALPHA = 1e-3
#: Numbers of which a remainder of the index could tell a level.
PERIODS = (2, 3, 4, 5, 6, 8, 12, 16)
NAMES = ("collide", "direction", "count", "support", "trajectory", "speed", "relation", "drop")
TASKS = [path for path in SPECS if path.stem in NAMES]
#: The larger designs of them are guessed where slow tests run.
LARGE = ("relation", "drop", "direction", "speed")
GUESSED = slow_except([path for path in TASKS if path.stem not in LARGE], TASKS)
#: A guess of a level from the index and the block, which the attacker sees.
Guess = Callable[[str, Instance], object]


class Remembered:
    """A design that computes each instance once: many guesses look at the same instances."""

    def __init__(self, design: Design) -> None:
        self.blocks = design.blocks
        self._design = design
        self._instances: dict[int, Instance] = {}

    def __getitem__(self, index: int) -> Instance:
        if index not in self._instances:
            self._instances[index] = self._design[index]
        return self._instances[index]


def one_of_each_group(design: Remembered, blocks: range) -> Iterator[Instance]:
    """An instance of every group, at random: these are independent of one another."""
    for block in blocks:
        members = design.blocks.members(block)
        yield design[members[bits("pick", block) % len(members)]]


def hits(design: Remembered, guess: Guess, blocks: range) -> dict[str, tuple[int, int, float]]:
    """Of each factor crossed in these groups: right guesses, guesses, and the probability of being right by chance."""
    found: defaultdict[str, list[bool]] = defaultdict(list)
    levels: dict[str, Counter[object]] = {}
    for instance in one_of_each_group(design, blocks):
        for name in instance.crossed:
            if name not in levels:
                members = design.blocks.members(instance.block)
                levels[name] = Counter(design[i].factors[name] for i in members)
            found[name].append(guess(name, instance) == instance.factors[name])
    even = {name: count for name, count in levels.items() if len(set(count.values())) == 1}
    return {name: (sum(found[name]), len(found[name]), 1 / len(count)) for name, count in even.items()}


def at_chance(design: Remembered, guess: Guess, blocks: range, tests: int) -> bool:
    """Whether every crossed factor is guessed at chance, by the exact binomial test, with Bonferroni correction."""
    counted = hits(design, guess, blocks)
    assert counted
    return all(binomtest(*each).pvalue > ALPHA / (len(counted) * tests * len(TASKS)) for each in counted.values())


def majority(design: Remembered, key: Callable[[Instance], object], blocks: range) -> Guess:
    """Guess the level that is most frequent for a key, as learnt from some groups, all of whose levels are known."""
    known: defaultdict[tuple[str, object], Counter[object]] = defaultdict(Counter)
    for block in blocks:
        for index in design.blocks.members(block):
            instance = design[index]
            for name in instance.crossed:
                known[name, key(instance)][instance.factors[name]] += 1
    return lambda name, instance: max(known[name, key(instance)].items(), key=_often, default=(None, 0))[0]


def _often(item: tuple[object, int]) -> tuple[int, str]:
    return item[1], str(item[0])


def test_the_tasks_are_there() -> None:
    assert len(TASKS) == len(NAMES)


@pytest.mark.parametrize("path", GUESSED, ids=lambda p: p.stem)
def test_another_seed_recomputes_the_factors_at_chance(path: Path) -> None:
    spec = task_of(path)
    secret = Remembered(Design(spec, bits("secret", spec.name)))
    whole = range(secret.blocks.count)
    for seed in (0, 7, 11):
        other = Remembered(Design(spec, seed))
        assert at_chance(secret, lambda name, i, other=other: other[i.index].factors[name], whole, 3)  # type: ignore[misc]
    assert not at_chance(secret, lambda name, i: secret[i.index].factors[name], whole, 1)


@pytest.mark.parametrize("path", GUESSED, ids=lambda p: p.stem)
def test_levels_do_not_follow_from_remainders_of_the_index(path: Path) -> None:
    """Who knows the levels of half of the groups learns nothing from indices about those of the other half."""
    spec = task_of(path)
    secret = Remembered(Design(spec, bits("secret", spec.name)))
    count = secret.blocks.count
    first, second = range(count // 2), range(count // 2, count)
    for period in PERIODS:
        for key in (lambda i, k=period: i.index % k, lambda i, k=period: i.block % k):
            assert at_chance(secret, majority(secret, key, first), second, 2 * len(PERIODS))


@pytest.mark.parametrize(
    "plan",
    [
        Plan(),
        Plan(kind="sample", count=500),
        Plan(kind="latin", count=500),
        Plan(kind="groups", count=400, cross=("a",)),
    ],
    ids=lambda plan: plan.kind,
)
def test_no_plan_is_in_an_order(plan: Plan) -> None:
    """Neither another seed nor the remainders of the index tell a level, of any factor that is not tied to a group."""
    spec = design_of({"a": 2, "b": 3, "c": 4, "d": 5}, compare("!=", "b", "d"), plan=plan, repeat=4)
    design, other = Design(spec, 12345), Design(spec, 54321)
    for name in "abc" if plan.kind != "groups" else "a":
        mine, theirs = ([i.factors[name] for i in each] for each in (design, other))
        level = Counter(mine)
        chance = sum((n / len(mine)) ** 2 for n in level.values())
        same = sum(a == b for a, b in zip(mine, theirs, strict=True))
        assert binomtest(same, len(mine), chance).pvalue > ALPHA / 100
        for period in PERIODS:
            table = Counter((i % period, value) for i, value in enumerate(mine[: len(mine) // 2]))
            best = {r: max((table[r, value], str(value), value) for value in level)[2] for r in range(period)}
            rest = range(len(mine) // 2, len(mine))
            right = sum(mine[i] == best[i % period] for i in rest)
            assert binomtest(right, len(rest), max(level.values()) / len(mine), "greater").pvalue > ALPHA / 100


@examples(20, 60, deadline=None)
@given(count=st.integers(1, 60), seed=st.integers(0, 2**62), sizes=st.tuples(*[st.integers(1, 4)] * 3))
def test_the_order_moves_instances_and_nothing_else(count: int, seed: int, sizes: tuple[int, ...]) -> None:
    """Every combination of a group has one index, and its index has it; neighbours are found in both directions."""
    spec = design_of(
        dict(zip("abc", sizes, strict=True)), plan=Plan(kind="groups", count=count, cross=("a",), turn=("b", "c"))
    )
    design = Design(spec, seed)
    for here in design:
        assert design.index(here.factors, here.block) == here.index
        for name in here.crossed:
            assert all(here.index in design.neighbours(other, name) for other in design.neighbours(here.index, name))


# ---------------------------------------------------------------- keys and ids


def test_group_keys_are_of_the_seed() -> None:
    """Else trying all levels of the other factors would tell them."""
    spec = design_of({"a": 2, "b": 3}, plan=Plan(kind="groups", count=4, cross=("a",), turn=("b",)))
    one, other = (groups(Design(spec, seed)[0]) for seed in (1, 2))
    assert all(one[name] != other[name] for name in one)
    members = [Design(spec, 1)[i] for i in Design(spec, 1).blocks.members(0)]
    assert len({groups(i)["a"] for i in members if i.factors["b"] == members[0].factors["b"]}) == 1


def test_ids_are_short_and_typable() -> None:
    assert re.fullmatch(rf"collide/[{DIGITS}]{{4}}(-[{DIGITS}]{{4}}){{3}}", identity(3, "collide", 7, 0, "mujoco"))
    assert not set(DIGITS) & set("ilou")


@given(key=st.tuples(st.integers(-9, 2**63), st.text("ab_", min_size=1), st.integers(0, 99), st.integers(0, 9)))
def test_an_id_depends_on_all_that_it_names(key: tuple[int, str, int, int]) -> None:
    seed, task, index, question = key
    own = {identity(*key), identity(*key, "mujoco"), identity(*key, "")}
    others = {
        identity(seed + 1, task, index, question), identity(seed, task + "a", index, question),
        identity(seed, task, index + 1, question), identity(seed, task, index, question + 1),
    }  # fmt: skip
    assert len(own) == 3
    assert len(own | others) == 7
    assert identity(*key) == identity(*key)


def test_ids_are_in_no_order() -> None:
    """The order of ids has nothing to do with that of indices, and their bits are even."""
    ids = [identity(5, "t", i, 0) for i in range(2000)]
    assert len(set(ids)) == 2000
    rising = sum(a < b for a, b in zip(ids[::2], ids[1::2], strict=True))
    assert binomtest(rising, 1000).pvalue > ALPHA / 100
    for place in [i for i, c in enumerate(ids[0]) if c != "-" and i > 1]:
        low = sum(DIGITS.index(each[place]) < 16 for each in ids)
        assert binomtest(low, 2000).pvalue > ALPHA / 100


def test_an_instance_of_a_public_spec_is_not_found_by_its_id() -> None:
    """All ids of a design under another seed are other ids."""
    spec: TaskSpec = design_of({"a": 4, "b": 25})
    size = len(Design(spec))
    mine, theirs = ({identity(seed, spec.name, i, 0, "mujoco") for i in range(size)} for seed in (0, 2**62 + 5))
    assert not mine & theirs
