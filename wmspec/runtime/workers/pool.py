"""Work in several processes: results in order; work that fails, dies or hangs costs nothing but its own piece."""

from __future__ import annotations

import gc
import signal
import sys
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, wait
from concurrent.futures import TimeoutError as FutureTimeout
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import chain, islice
from multiprocessing.context import SpawnContext, SpawnProcess
from types import ModuleType
from typing import Any, Literal, Protocol, TypeVar, cast

from pebble import ProcessExpired, ProcessPool

from wmspec.core.crash import Crash
from wmspec.core.diagnostics import GraphicsError, WmsError

T = TypeVar("T")
Piece = tuple[Any, ...]

#: A worker is replaced after so many pieces of work, which bounds whatever an engine leaks.
PIECES_PER_WORKER = 1000
#: So many pieces are with a worker at a time, so that it need not wait for the next.
AHEAD = 2
#: So many times in a row workers may vanish before they say what they do, until the job that is waited for is lost.
PATIENCE = 10


@dataclass(frozen=True)
class Effort:
    """How hard to try: worker processes, and the seconds that a piece of work may take.

    Without workers, all is done in this process, where nothing stops a piece that hangs. `hire` gives a worker that is
    not a process of this machine.
    """

    workers: int
    timeout: float
    hire: Callable[[], Workers] | None = None


@dataclass(frozen=True)
class Lost:
    """A piece of work that came to nothing, and why.

    `timeout` and `crashed` (twice each) depend on the machine and on what else it does: the same piece may succeed at
    another time. An `error` is its own; `crash` is the exception, if it was an unexpected one.
    """

    kind: Literal["timeout", "crashed", "error"]
    reason: str
    crash: Crash | None = field(default=None, compare=False)


def in_order(
    work: Callable[..., T],
    pieces: Iterable[tuple[Any, ...]],
    effort: Effort,
    weight: Callable[[tuple[Any, ...]], int] = lambda _: 1,
) -> Generator[T | Lost, None, None]:
    """`work(*piece)` for every piece, in order, with only as many under way as keep the workers busy.

    A piece may take as many times the seconds as is its `weight`. Close it to stop them. Raises GraphicsError if a
    worker does: then this machine cannot draw, whatever the piece.
    """
    if effort.workers == 0:
        yield from (_done(work, *piece) for piece in pieces)
    elif first := list(islice(every := iter(pieces), effort.workers)):
        yield from _in_workers(work, chain(first, every), effort, len(first), weight)


def by_units(
    work: Callable[..., T],
    units: Iterable[Sequence[Piece]],
    effort: Effort,
    weight: Callable[[Piece], int] = lambda _: 1,
) -> Generator[tuple[Piece, T | Lost], None, None]:
    """`work(*piece)` for every piece of every unit, each with its piece, as they are done.

    All pieces of a unit are done by one worker, one after the other, so that it can use again what it knows from the
    one for the next. Otherwise as `in_order`.
    """
    if effort.workers == 0:
        yield from ((piece, _done(work, *piece)) for unit in units for piece in unit)
        return
    first = list(islice(rest := iter(units), effort.workers))
    waiting, seats = chain(first, rest), list[_Seat]()
    try:
        seats += (_Seat((effort.hire or LocalWorkers)()) for _ in first)
        while True:
            for seat in seats:
                seat.fill(waiting, lambda piece: Job(work, piece, effort.timeout * weight(piece)))
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
        with undisturbed():
            for seat in seats:
                seat.workers.stop()
        raise


def _in_workers(
    work: Callable[..., T],
    pieces: Iterable[tuple[Any, ...]],
    effort: Effort,
    workers: int,
    weight: Callable[[tuple[Any, ...]], int],
) -> Generator[T | Lost, None, None]:
    under_way: deque[Job] = deque()
    pool = LocalWorkers(workers)
    try:
        for piece in pieces:
            under_way.append(Job(work, piece, effort.timeout * weight(piece)))
            pool.take(under_way[-1], under_way)
            if len(under_way) > 4 * workers:
                yield cast(T, result(under_way.popleft(), under_way, pool))
        while under_way:
            yield cast(T, result(under_way.popleft(), under_way, pool))
    except BaseException:
        pool.stop()
        raise
    pool.finish()


def result(job: Job, others: Iterable[Job], pool: Workers) -> Any:
    """What became of a job, which is tried twice, while others are under way."""
    try:
        try:
            return pool.result(job, others)
        except (ProcessExpired, FutureTimeout):
            pool.take(job, others)
            return pool.result(job, others)
    except FutureTimeout:
        return Lost("timeout", f"took longer than {job.timeout:g} s, twice")
    except ProcessExpired as error:
        return Lost("crashed", f"the worker process died twice (exit code {error.exitcode})")
    except BrokenProcessPool:
        return Lost("crashed", "the worker processes died before they began")


@dataclass
class Job:
    """A piece of work, the seconds that it may take, and its result to come."""

    work: Callable[..., Any]
    piece: tuple[Any, ...]
    timeout: float
    future: Any = None


@dataclass
class _Seat:
    """One worker, what it has to do of its unit, and the jobs that were given to it."""

    workers: Workers
    unit: deque[Piece] = field(default_factory=deque)
    jobs: deque[Job] = field(default_factory=deque)

    def fill(self, units: Iterator[Sequence[Piece]], job: Callable[[Piece], Job]) -> None:
        """Give it the next pieces, of another unit if its own is done."""
        while len(self.jobs) < AHEAD:
            if not self.unit:
                self.unit.extend(next(units, ()))
            if not self.unit:
                return
            self.jobs.append(job(self.unit.popleft()))
            self.workers.take(self.jobs[-1], self.jobs)


class Workers(Protocol):
    """Those who do jobs, wherever they are."""

    def take(self, job: Job, others: Iterable[Job]) -> None:
        """Have a job done, while others are under way."""

    def done(self, jobs: Sequence[Job]) -> bool:
        """Whether the first of their jobs is done, or given up."""

    def result(self, job: Job, others: Iterable[Job]) -> Any:
        """What a job gives."""

    def finish(self) -> None:
        """Wait until all that was taken is done."""

    def stop(self) -> None:
        """End them, whatever they are doing."""


class LocalWorkers:
    """The processes that do the work.

    Where one dies before it has said which job it took, pebble gives up all of them. Others then take over what
    was under way, and only if that happens `PATIENCE` times in a row the job that is waited for is lost.
    """

    def __init__(self, count: int = 1) -> None:
        self._count = count
        self._begin()

    def take(self, job: Job, others: Iterable[Job]) -> None:
        """Have the job done."""
        if not self._pool.active:
            self._renew(other for other in others if other is not job)
        self._schedule(job)

    def done(self, jobs: Sequence[Job]) -> bool:
        """Whether the first of their jobs is done, or given up."""
        return bool(jobs[0].future.done() or not self._pool.active)

    def result(self, job: Job, others: Iterable[Job]) -> Any:
        """What the job gives. Raises what pebble does, BrokenProcessPool if the processes die again and again."""
        for _ in range(PATIENCE):
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
        """Wait until all that was taken is done."""
        with undisturbed():
            self._pool.close()
            self._pool.join()

    def stop(self) -> None:
        """End the processes, whatever they are doing."""
        with undisturbed():
            self._pool.stop()
            self._pool.join()

    def _begin(self) -> None:
        pool = {"max_workers": self._count, "max_tasks": PIECES_PER_WORKER, "context": _Context()}
        self._pool: Any = ProcessPool(**pool, initializer=_seldom_collected)
        with undisturbed():
            _ = self._pool.active  # asked for this, it begins

    def _renew(self, jobs: Iterable[Job]) -> None:
        undone = [j for j in jobs if not j.future.done() or isinstance(j.future.exception(), BrokenProcessPool)]
        self.stop()
        self._begin()
        for job in undone:
            self._schedule(job)

    def _schedule(self, job: Job) -> None:
        with undisturbed():
            job.future = self._pool.schedule(_done, args=(job.work, *job.piece), timeout=job.timeout)


def _seldom_collected() -> None:
    """Look for cycles of objects seldom: specs and scenes are many objects and have none, and looking takes a fifth."""
    gc.set_threshold(100_000, 20, 100)


def _done(work: Callable[..., T], *piece: Any) -> T | Lost:
    """The work, where it is done, or what went wrong with it."""
    try:
        return work(*piece)
    except GraphicsError:
        raise
    except MemoryError:
        return Lost("crashed", "there was not enough memory")
    except WmsError as error:
        return Lost("error", str(error))
    except Exception as error:  # noqa: BLE001  whatever it is, it must not cost the other pieces
        crash = Crash.of(error, skip=1)  # this frame
        return Lost("error", crash.line, crash)


@contextmanager
def undisturbed() -> Iterator[None]:
    """What signals do, they do afterwards.

    Where one raises an exception while a queue wakes its reader, the next word to the reader is lost (in
    `threading.Condition.notify`): the processes never end, nor does what waits for them. Ray aborts, or ends by an exit
    code of its own.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    ours = {number: handler for number, handler in handlers.items() if callable(handler)}
    for number in ours:
        signal.signal(number, lambda number, _: came.append(number))
    try:
        yield
    finally:
        for number, handler in ours.items():
            signal.signal(number, handler)
        for signalled in came:
            signal.raise_signal(signalled)


class Helper:
    """One process that stays, for one piece of work after the other: who waits for it is safe from whatever it does."""

    def __init__(self, timeout: float) -> None:
        self._workers = LocalWorkers(1)
        self._timeout = timeout

    def do(self, work: Callable[..., T], *piece: Any) -> T | Lost:
        """`work(*piece)`, or what became of it; it is tried once."""
        job = Job(work, piece, self._timeout)
        try:
            self._workers.take(job, ())
            return cast(T, self._workers.result(job, ()))
        except GraphicsError as error:
            return Lost("error", str(error))
        except FutureTimeout:
            return Lost("timeout", f"took longer than {self._timeout:g} s")
        except ProcessExpired as error:
            return Lost("crashed", f"the worker process died (exit code {error.exitcode})")
        except BrokenProcessPool:
            return Lost("crashed", "the worker process died before it began")

    def close(self) -> None:
        """Stop it, whatever it is doing."""
        self._workers.stop()


class _Worker(SpawnProcess):
    """A process that imports wmspec and not the script that asked for it, which therefore needs no `__main__` guard."""

    def start(self) -> None:
        script = sys.modules["__main__"]
        sys.modules["__main__"] = ModuleType("__main__")
        try:
            super().start()
        finally:
            sys.modules["__main__"] = script


class _Context(SpawnContext):
    Process = _Worker
