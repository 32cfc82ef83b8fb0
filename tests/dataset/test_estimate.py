"""Estimated cost of a dataset: the standard error reflects units that differ, and what they share counts once."""

import math
from itertools import pairwise

import pytest

import wmspec
from wmspec.core.resources import resource
from wmspec.dataset.build.batching import batches
from wmspec.dataset.build.estimate import _first_pieces, _rate, _seconds, _spaced_units, _Trial, _Unit
from wmspec.dataset.build.plan import Task
from wmspec.dataset.build.worker import Balance
from wmspec.runtime.workers.pool import JobFailure, PoolConfig


@pytest.fixture(scope="module")
def task() -> Task:
    spec = wmspec.load(resource("specs/perception/quantity/majority.wms"), task="majority_tabletop").spec
    return Task(spec, tuple(range(600)))


def test_units_from_all_over_a_task_are_tried(task: Task) -> None:
    tried, every = list(_spaced_units(task, 0)), list(batches(task.spec, 0, task.indices))
    where = [next(i for i, unit in enumerate(every) if one.pieces[0] in unit) for one in tried]
    assert where == sorted(set(where))
    assert max(b - a for a, b in pairwise(where)) <= math.ceil(len(every) / len(tried))
    assert [one.pieces for one in tried] == [every[i][:4] for i in where]
    assert all(one.other in every[i - 1] for one, i in zip(tried, where, strict=True))


def test_first_piece_runs_at_any_size() -> None:
    large, small = (1, 2, 3, 4, 5), (6,)
    assert _first_pieces([large, small], 4) == [large]
    assert _first_pieces([small, large, small], 4) == [small]
    assert _first_pieces([small] * 9, 4) == [small] * 4


def test_the_rest_of_a_unit_is_like_those_after_its_first() -> None:
    unit = _Unit(12, [(0,), (1,), (2,)], (99,))
    effort = PoolConfig(2, 100)
    assert _seconds(unit, _Trial((5.0, 1.0, 2.0), (), Balance()), effort) == pytest.approx(5 + 11 * 1.5)
    assert _seconds(_Unit(12, [(0, 1, 2)], (99,)), _Trial((6.0,), (), Balance()), effort) == pytest.approx(24)
    assert _seconds(unit, JobFailure("timeout", ""), effort) == 12 * 2 * 100
    assert _seconds(unit, JobFailure("error", ""), effort) == 0


def test_the_error_is_that_of_a_ratio() -> None:
    rate, error = _rate([(12.0, 12), (36.0, 12), (24.0, 12)], 600)
    assert rate == 2
    assert error == pytest.approx(1 / math.sqrt(3))  # 1, 3 and 2 s an instance: their deviation is 1
    assert _rate([(12.0, 12)], 600) == (1.0, None)
    assert _rate([(600.0, 300), (900.0, 300)], 600) == (2.5, 0.0), "all its units were tried"
