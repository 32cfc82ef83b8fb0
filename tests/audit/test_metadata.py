"""Numbers of a row that tell a level or the answer are found in several arrangements, and no others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from wmspec.dataset.audit import balance, metadata
from wmspec.dataset.audit.cases import Case, Unit
from wmspec.dataset.audit.model import Finding

WAYS = ("left", "right", "front", "back")

#: Returns the place in `WAYS` of each instance of a group: from the number of the group, and a random generator.
Arrange = Callable[[int, np.random.Generator], "list[int]"]


def shuffled(_group: int, random: np.random.Generator) -> list[int]:
    return random.permutation(4).tolist()


def in_turn(_group: int, _random: np.random.Generator) -> list[int]:
    return [0, 1, 2, 3]


def mostly_in_turn(group: int, random: np.random.Generator) -> list[int]:
    return in_turn(group, random) if random.random() < 0.6 else shuffled(group, random)


def by_group(group: int, _random: np.random.Generator) -> list[int]:
    return [group % 4] * 4


def of_group(_group: int, random: np.random.Generator) -> list[int]:
    return [int(random.integers(4))] * 4


def made(arrange: Arrange, seed: int, groups: int = 40, crossed: bool = True) -> Unit:
    """A unit of groups of four, of every third group of the design, whose answer is the way."""
    random = np.random.default_rng(seed)
    cases = []
    for group in range(0, 3 * groups, 3):
        for place, way in enumerate(arrange(group, random)):
            index = 4 * group + place
            row = {
                "id": f"t/{index:06d}/q0/mujoco",
                "index": index,
                "block": group,
                "crossed": ["way"] if crossed else [],
                "factor.way": WAYS[way],
                "text": "Where to?",
                "option_kind": ["label"] * 4,
                "option_name": list(WAYS),
                "answer": way,
            }
            cases.append(Case(row, (), ()))
    return Unit("t", tuple(cases), ("mujoco",))


def test_metadata_tests_of_a_task_share_their_false_alarms() -> None:
    """Of six tests, chance gives one below 0.009 in a twentieth of the tasks; no chance gives the smallest p-value."""
    test = metadata.level_tests(made(shuffled, 0))[0]

    def corrected(least: float) -> list[float]:
        return [one.corrected for one in balance.corrected_tests([replace(test, p=p) for p in (least, *[0.5] * 5)])]

    assert min(corrected(0.009)) == pytest.approx(0.054)
    assert min(corrected(1 / (1 + metadata.PERMUTATIONS))) == pytest.approx(0.003)


def failing(unit: Unit) -> list[Finding]:
    tests = balance.corrected_tests([*metadata.level_tests(unit), *metadata.answer_tests(unit)])
    return [f for f in map(balance.judge, tests) if f.verdict == "fails"]


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (7, 11))])
@pytest.mark.parametrize("arrange", [shuffled, of_group])
def test_random_order_carries_no_information(arrange: Arrange, seed: int) -> None:
    assert not failing(made(arrange, seed))


@pytest.mark.parametrize("arrange", [in_turn, mostly_in_turn])
def test_a_level_in_turn_is_found_and_named(arrange: Arrange) -> None:
    level, answer = failing(made(arrange, 7))
    assert level.check == answer.check == "metadata"
    assert level.what.startswith("level of `way` depends on ")
    assert answer.what.startswith("answer depends on ")
    assert "modulo 4" in level.what


def test_an_answer_in_turn_by_group_is_found() -> None:
    (answer,) = failing(made(by_group, 7, crossed=False))
    assert answer.what.startswith("answer depends on ")


def test_false_alarms_are_as_rare_as_stated(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two tests of a unit raise at most one alarm in a hundred units, with any number of permutations."""
    monkeypatch.setattr(metadata, "PERMUTATIONS", 499)
    units = 60
    alarms = sum(
        bool(failing(made(arrange, seed, 15))) for seed in range(units // 2) for arrange in (shuffled, of_group)
    )
    assert stats.binomtest(alarms, units, 2 * balance.SIGNIFICANCE / 2, "greater").pvalue > 1e-3


def test_an_id_of_hash_digits_is_a_number() -> None:
    unit = made(shuffled, 7)
    revealing = [
        Case(case.row | {"id": f"t/{16**9 + 8 * case.row['index'] + case.row['answer']:x}"}, (), ())
        for case in unit.cases
    ]
    (found, *_) = failing(Unit("t", tuple(revealing), ("mujoco",)))
    assert "depends on id modulo" in found.what
