"""A worker that dies or hangs costs its own piece of work and nothing else."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from typing import Any

import pytest

from wmspec.core.diagnostics import GraphicsError, WmsError
from wmspec.runtime.workers import pool
from wmspec.runtime.workers.pool import HelperProcess, JobFailure, PoolConfig, map_ordered


def square(i: int) -> int:
    if i == 2:
        os._exit(7)
    if i == 3:
        time.sleep(600)
    if i == 6:
        raise Unforeseen(f"at {hex(id(i))},\n all of it")
    if i == 7:
        return bytearray(1 << 60)[0]
    if i == 8:
        raise GraphicsError("there is no display")
    if i == 9:
        raise WmsError("it cannot be so", help="make it otherwise")
    return i * i


class Unforeseen(Exception):
    """An error that no worker could send back: it needs more than its text to be made."""

    def __init__(self, text: str, *, lock: object = None) -> None:
        super().__init__(text)
        self.lock = lock or (i for i in "")


def test_results_are_in_order_and_losses_are_reported() -> None:
    found = list(map_ordered(square, ((i,) for i in (0, 1, 2, 4, 5)), PoolConfig(workers=2, timeout=60)))
    assert found == [0, 1, JobFailure("crashed", "the worker process died twice (exit code 7)"), 16, 25]


@pytest.mark.parametrize("workers", [0, 2])
def test_failure_costs_its_own_piece(workers: int) -> None:
    results = list(map_ordered(square, ((i,) for i in (1, 6, 7, 9, 4)), PoolConfig(workers, timeout=60)))
    assert results == [
        1,
        JobFailure("error", "Unforeseen: at 0x..., all of it"),
        JobFailure("crashed", "there was not enough memory"),
        JobFailure("error", "it cannot be so; make it otherwise"),
        16,
    ]


@pytest.mark.parametrize(("module", "place"), [("other", ""), ("wmspec.other", " (wmspec/other.py:2)")])
def test_reason_names_the_line_of_wmspec(module: str, place: str) -> None:
    names: dict[str, Any] = {"__name__": module}
    exec(compile("def work(i):\n    raise ValueError('no')", "/home/me/wmspec/other.py", "exec"), names)
    assert list(map_ordered(names["work"], [(1,)], PoolConfig(0, timeout=60))) == [
        JobFailure("error", f"ValueError: no{place}")
    ]


@pytest.mark.parametrize("workers", [0, 2])
def test_a_machine_that_cannot_draw_is_no_fault_of_a_piece(workers: int) -> None:
    with pytest.raises(GraphicsError, match="no display"):
        list(map_ordered(square, ((i,) for i in (1, 8, 4)), PoolConfig(workers, timeout=60)))


def test_an_idle_process_that_is_killed_costs_nothing() -> None:
    """As the kernel does where memory runs out: the pool is broken then, and another takes over."""
    helper = HelperProcess(timeout=60)
    try:
        for i in (4, 5):
            assert helper.do(square, i) == i * i
            for child in multiprocessing.active_children():
                child.kill()
                child.join()
    finally:
        helper.close()


def test_there_are_no_more_workers_than_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    questions: list[int] = []
    real = pool.ProcessPool  # type: ignore[attr-defined]

    def noted(max_workers: int, **options: object) -> object:
        questions.append(max_workers)
        return real(max_workers=max_workers, **options)

    monkeypatch.setattr(pool, "ProcessPool", noted)
    assert list(map_ordered(square, ((i,) for i in (4, 5)), PoolConfig(workers=500, timeout=60))) == [16, 25]
    assert list(map_ordered(square, (), PoolConfig(workers=500, timeout=60))) == []
    assert questions == [2]


def test_ctrl_c_reaches_no_worker_from_its_start_on() -> None:
    helper = HelperProcess(60)
    try:
        masked = helper.do(signal.pthread_sigmask, signal.SIG_BLOCK, ())
        assert not isinstance(masked, JobFailure)
        assert signal.SIGINT in masked
    finally:
        helper.close()
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, ())


def test_hanging_jobs_time_out() -> None:
    found = list(map_ordered(square, ((i,) for i in (3,)), PoolConfig(workers=2, timeout=3)))
    assert found == [JobFailure("timeout", "took longer than 3 s, twice")]


def test_a_pool_that_is_closed_stops_its_work() -> None:
    results = map_ordered(square, ((i,) for i in (1, 3)), PoolConfig(workers=2, timeout=600))
    assert next(results) == 1
    started = time.monotonic()
    results.close()
    assert time.monotonic() - started < 300, "it was not waited for"


INTERRUPTED = """
import signal, threading, time
from wmspec.runtime.workers.pool import PoolConfig, map_batches

notify = threading.Condition.notify

def interrupted(self, n=1):
    if on and self._waiters and threading.current_thread() is threading.main_thread():
        on.clear()
        self._waiters[0].release()  # as `notify` does, which a signal interrupts before the next line
        signal.raise_signal(signal.SIGINT)
        self._waiters.popleft()
    else:
        notify(self, n)

signal.signal(signal.SIGINT, signal.default_int_handler)  # which a shell has jobs in the background ignore
on = []
threading.Condition.notify = interrupted
results = map_batches(time.sleep, [[(30,)] * 2, [(0.2,)] * 20], PoolConfig(workers=2, timeout=60))
next(results)
on.append(True)
try:
    list(results)
except KeyboardInterrupt:
    print("ended", on)
"""


def test_a_signal_while_work_is_handed_over_ends_all_the_same() -> None:
    """A run that received a termination signal once waited for ever."""
    done = subprocess.run([sys.executable, "-c", INTERRUPTED], capture_output=True, text=True, check=False, timeout=120)
    assert done.stdout == "ended []\n", done.stderr


def test_ctrl_c_reaches_no_reader_of_clips_from_its_start_on() -> None:
    """Ctrl-C while its Python started showed a traceback."""
    pytest.importorskip("av")
    from wmspec.eval.clips.read import clip_reader

    with clip_reader() as reader:
        assert signal.SIGINT in reader._pool.schedule(signal.pthread_sigmask, args=[signal.SIG_BLOCK, ()]).result()
