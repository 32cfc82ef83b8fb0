"""A worker that dies or hangs costs its own piece of work and nothing else."""

import os
import time

from wmspec.execute.pool import Effort, Lost, in_order


def square(i: int) -> int:
    if i == 2:
        os._exit(7)
    if i == 3:
        time.sleep(600)
    return i * i


def test_results_are_in_order_and_what_is_lost_is_told() -> None:
    found = list(in_order(square, ((i,) for i in (0, 1, 2, 4, 5)), Effort(workers=2, timeout=60)))
    assert found == [0, 1, Lost("crashed", "the worker process died twice (exit code 7)"), 16, 25]


def test_what_hangs_is_given_up() -> None:
    found = list(in_order(square, ((i,) for i in (3,)), Effort(workers=2, timeout=3)))
    assert found == [Lost("timeout", "took longer than 3 s, twice")]


def test_a_pool_that_is_closed_stops_its_work() -> None:
    results = in_order(square, ((i,) for i in (1, 3)), Effort(workers=2, timeout=600))
    assert next(results) == 1
    started = time.monotonic()
    results.close()
    assert time.monotonic() - started < 300, "it was not waited for"
