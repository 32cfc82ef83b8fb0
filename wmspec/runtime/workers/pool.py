"""A process pool with ordered results; a job that fails, crashes or hangs affects no other job."""

from __future__ import annotations

import gc
import signal
import sys
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, wait
from concurrent.futures import TimeoutError as FutureTimeout
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from itertools import chain, islice
from multiprocessing.context import SpawnContext, SpawnProcess
from types import ModuleType
from typing import Any, Literal, Protocol, TypeVar, cast

from pebble import ProcessExpired, ProcessPool

from wmspec.core.crash import Crash
from wmspec.core.diagnostics import GraphicsError, WmsError
from wmspec.core.signals import defer_signals

T = TypeVar("T")
Piece = tuple[Any, ...]

#: Number of jobs after which a worker is replaced, which bounds memory leaks of engines.
MAX_JOBS_PER_WORKER = 1000
#: Number of jobs queued per worker, so that it never idles.
PREFETCH = 2
#: Number of consecutive times that workers may vanish before starting, until the awaited job fails.
MAX_RETRIES = 10


@dataclass(frozen=True)
class PoolConfig:
    """Worker processes, and the timeout (s) of a job.

    Without workers, jobs run in this process, where a hanging job cannot be stopped. `worker_factory` creates a
    worker that is not a process of this machine.
    """

    workers: int
    timeout: float
    worker_factory: Callable[[], Workers] | None = None


@dataclass(frozen=True)
class JobFailure:
    """A job without a result, and the reason.

    `timeout` and `crashed` (twice each) depend on the machine and its load: the same job may succeed later. An `error`
    is deterministic.
    """

    kind: Literal["timeout", "crashed", "error"]
    reason: str
    crash: Crash | None = field(default=None, compare=False)


def map_ordered(
    work: Callable[..., T],
    pieces: Iterable[tuple[Any, ...]],
    effort: PoolConfig,
    weight: Callable[[tuple[Any, ...]], int] = lambda _: 1,
) -> Generator[T | JobFailure, None, None]:
    """Yield `work(*piece)` for every piece, in order, with a bounded number of pieces in progress.

    The timeout of a piece is multiplied by its `weight`. Close the generator to stop the workers. Raises GraphicsError
    if a worker does: the machine then cannot render any piece.
    """
    if effort.workers == 0:
        yield from (_run_job(work, *piece) for piece in pieces)
    elif first := list(islice(every := iter(pieces), effort.workers)):
        yield from _in_workers(work, chain(first, every), effort, len(first), weight)


def map_batches(
    work: Callable[..., T],
    units: Iterable[Sequence[Piece]],
    effort: PoolConfig,
    weight: Callable[[Piece], int] = lambda _: 1,
) -> Generator[tuple[Piece, T | JobFailure], None, None]:
    """Yield every piece of every unit with `work(*piece)`, as they finish.

    One worker processes all pieces of a unit in order, so that its caches apply. Otherwise like `map_ordered`.
    """
    if effort.workers == 0:
        yield from ((piece, _run_job(work, *piece)) for unit in units for piece in unit)
        return
    first = list(islice(rest := iter(units), effort.workers))
    waiting, seats = chain(first, rest), list[_WorkerSlot]()
    try:
        seats += (_WorkerSlot((effort.worker_factory or LocalWorkers)()) for _ in first)
        while True:
            for seat in seats:
                seat.fill(waiting, lambda piece: PoolJob(work, piece, effort.timeout * weight(piece)))
            for seat in [seat for seat in seats if not seat.jobs]:
                seat.workers.finish()
                seats.remove(seat)
            if not seats:
                return
            wait([seat.jobs[0].future for seat in seats], timeout=1, return_when=FIRST_COMPLETED)
            for seat in seats:
                if seat.workers.done(seat.jobs):
                    job = seat.jobs.popleft()
                    yield job.piece, cast(T, result(job, seat.jobs, seat.workers))
    except BaseException:
        with defer_signals():
            for seat in seats:
                seat.workers.stop()
        raise


def _in_workers(
    work: Callable[..., T],
    pieces: Iterable[tuple[Any, ...]],
    effort: PoolConfig,
    workers: int,
    weight: Callable[[tuple[Any, ...]], int],
) -> Generator[T | JobFailure, None, None]:
    under_way: deque[PoolJob] = deque()
    pool = LocalWorkers(workers)
    try:
        for piece in pieces:
            under_way.append(PoolJob(work, piece, effort.timeout * weight(piece)))
            pool.take(under_way[-1], under_way)
            if len(under_way) > 4 * workers:
                yield cast(T, result(under_way.popleft(), under_way, pool))
        while under_way:
            yield cast(T, result(under_way.popleft(), under_way, pool))
    except BaseException:
        pool.stop()
        raise
    pool.finish()


def result(job: PoolJob, others: Iterable[PoolJob], pool: Workers) -> Any:
    """Return the result of a job, which is tried twice, while others are in progress."""
    try:
        try:
            return pool.result(job, others)
        except (ProcessExpired, FutureTimeout):
            pool.take(job, others)
            return pool.result(job, others)
    except FutureTimeout:
        return JobFailure("timeout", f"took longer than {job.timeout:g} s, twice")
    except ProcessExpired as error:
        return JobFailure("crashed", f"the worker process died twice (exit code {error.exitcode})")
    except BrokenProcessPool:
        return JobFailure("crashed", "the worker processes died before they began")


@dataclass
class PoolJob:
    """Arguments of one call, its timeout (s), and its future."""

    work: Callable[..., Any]
    piece: tuple[Any, ...]
    timeout: float
    future: Any = None


@dataclass
class _WorkerSlot:
    """One worker, the remaining pieces of its unit, and its queued jobs."""

    workers: Workers
    unit: deque[Piece] = field(default_factory=deque)
    jobs: deque[PoolJob] = field(default_factory=deque)

    def fill(self, units: Iterator[Sequence[Piece]], job: Callable[[Piece], PoolJob]) -> None:
        """Queue the next pieces, from another unit when its own is done."""
        while len(self.jobs) < PREFETCH:
            if not self.unit:
                self.unit.extend(next(units, ()))
            if not self.unit:
                return
            self.jobs.append(job(self.unit.popleft()))
            self.workers.take(self.jobs[-1], self.jobs)


class Workers(Protocol):
    """An executor of jobs, local or remote."""

    def take(self, job: PoolJob, others: Iterable[PoolJob]) -> None:
        """Submit a job, while others are in progress."""

    def done(self, jobs: Sequence[PoolJob]) -> bool:
        """Whether the first of its jobs is done or abandoned."""

    def result(self, job: PoolJob, others: Iterable[PoolJob]) -> Any:
        """Return the result of a job."""

    def finish(self) -> None:
        """Wait until all submitted jobs are done."""

    def stop(self) -> None:
        """Kill the workers."""


class LocalWorkers:
    """Worker processes on this machine.

    If one dies before it reports its job, pebble abandons all of them. New processes then resume the jobs in progress.
    The awaited job fails only if that happens `MAX_RETRIES` times in a row.
    """

    def __init__(self, count: int = 1) -> None:
        self._count = count
        self._begin()

    def take(self, job: PoolJob, others: Iterable[PoolJob]) -> None:
        """Submit a job."""
        if not self._pool.active:
            self._renew(other for other in others if other is not job)
        self._schedule(job)

    def done(self, jobs: Sequence[PoolJob]) -> bool:
        """Whether the first of its jobs is done or abandoned."""
        return bool(jobs[0].future.done() or not self._pool.active)

    def result(self, job: PoolJob, others: Iterable[PoolJob]) -> Any:
        """Return the result of a job. Raises pebble's errors, BrokenProcessPool if the processes keep dying."""
        for _ in range(MAX_RETRIES):
            while not wait([job.future], timeout=1).done and self._pool.active:
                pass
            try:
                if job.future.done():
                    return job.future.result()
            except BrokenProcessPool:
                pass
            self._renew([job, *others])
        raise BrokenProcessPool

    def finish(self) -> None:
        """Wait until all submitted jobs are done."""
        with defer_signals():
            self._pool.close()
            self._pool.join()

    def stop(self) -> None:
        """Kill the processes."""
        with defer_signals():
            self._pool.stop()
            self._pool.join()

    def _begin(self) -> None:
        pool = {"max_workers": self._count, "max_tasks": MAX_JOBS_PER_WORKER, "context": WorkerContext()}
        self._pool: Any = ProcessPool(**pool, initializer=_relax_gc)
        with defer_signals():
            _ = self._pool.active  # reading this starts the processes

    def _renew(self, jobs: Iterable[PoolJob]) -> None:
        undone = [j for j in jobs if not j.future.done() or isinstance(j.future.exception(), BrokenProcessPool)]
        self.stop()
        self._begin()
        for job in undone:
            self._schedule(job)

    def _schedule(self, job: PoolJob) -> None:
        with defer_signals():
            job.future = self._pool.schedule(_run_job, args=(job.work, *job.piece), timeout=job.timeout)


class PersistentWorkers(LocalWorkers):
    """A worker process that several calls of `map_batches` use in turn, until it is closed."""

    def finish(self) -> None:
        """Keep the process: all of its jobs are done."""

    def close(self) -> None:
        """Kill the process."""
        self.stop()


def _relax_gc() -> None:
    """Raise GC thresholds: specs and scenes are acyclic, and collection costs ~20 %."""
    gc.set_threshold(100_000, 20, 100)


def _run_job(work: Callable[..., T], *piece: Any) -> T | JobFailure:
    """Return the result of a job, or its failure; runs in the worker."""
    try:
        return work(*piece)
    except GraphicsError:
        raise
    except MemoryError:
        return JobFailure("crashed", "there was not enough memory")
    except WmsError as error:
        return JobFailure("error", str(error))
    except Exception as error:  # noqa: BLE001  whatever it is, it must not cost the other pieces
        crash = Crash.of(error, skip=1)  # this frame
        return JobFailure("error", crash.line, crash)


class HelperProcess:
    """One persistent process for successive jobs; its crashes and hangs do not affect the caller."""

    def __init__(self, timeout: float) -> None:
        self._workers = LocalWorkers(1)
        self._timeout = timeout

    def do(self, work: Callable[..., T], *piece: Any) -> T | JobFailure:
        """Return `work(*piece)` or its failure; it is tried once."""
        job = PoolJob(work, piece, self._timeout)
        try:
            self._workers.take(job, ())
            return cast(T, self._workers.result(job, ()))
        except GraphicsError as error:
            return JobFailure("error", str(error))
        except FutureTimeout:
            return JobFailure("timeout", f"took longer than {self._timeout:g} s")
        except ProcessExpired as error:
            return JobFailure("crashed", f"the worker process died (exit code {error.exitcode})")
        except BrokenProcessPool:
            return JobFailure("crashed", "the worker process died before it began")

    def close(self) -> None:
        """Kill it."""
        self._workers.stop()


class _Worker(SpawnProcess):
    """A process that does not import the main script, which therefore needs no `__main__` guard.

    Ctrl-C, which a terminal sends to it too, is for the main process. The mask is inherited, so that it holds while
    Python starts.
    """

    def start(self) -> None:
        script = sys.modules["__main__"]
        sys.modules["__main__"] = ModuleType("__main__")
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            super().start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
            sys.modules["__main__"] = script


class WorkerContext(SpawnContext):
    """Starts processes that ignore Ctrl-C from their start on, and do not import the main script."""

    Process = _Worker
