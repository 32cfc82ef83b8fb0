"""Work in several processes: results in order; a worker that dies or hangs costs nothing but its own piece of work."""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import TimeoutError as FutureTimeout
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.context import SpawnContext, SpawnProcess
from types import ModuleType
from typing import Any, Literal, TypeVar, cast

from pebble import ProcessExpired, ProcessPool

T = TypeVar("T")

#: A worker is replaced after so many pieces of work, which bounds whatever an engine leaks.
PIECES_PER_WORKER = 500


@dataclass(frozen=True)
class Effort:
    """How hard to try: worker processes, and the seconds that a piece of work may take.

    Without workers, all is done in this process, where nothing stops a piece that hangs.
    """

    workers: int
    timeout: float


@dataclass(frozen=True)
class Lost:
    """A piece of work that failed twice, and how."""

    kind: Literal["timeout", "crashed"]
    reason: str


def in_order(
    work: Callable[..., T], pieces: Iterable[tuple[Any, ...]], effort: Effort
) -> Generator[T | Lost, None, None]:
    """`work(*piece)` for every piece, in order, with only as many under way as keep the workers busy.

    Close it to stop them.
    """
    if effort.workers == 0:
        yield from (work(*piece) for piece in pieces)
        return
    with _pool(effort.workers) as pool:

        def schedule(piece: tuple[Any, ...]) -> Any:
            return pool.schedule(work, args=piece, timeout=effort.timeout)

        def result(piece: tuple[Any, ...], future: Any) -> T | Lost:
            try:
                return cast(T, future.result())
            except (ProcessExpired, FutureTimeout):
                pass
            try:
                return cast(T, schedule(piece).result())
            except FutureTimeout:
                return Lost("timeout", f"took longer than {effort.timeout:g} s, twice")
            except ProcessExpired as error:
                return Lost("crashed", f"the worker process died twice (exit code {error.exitcode})")

        under_way: deque[tuple[tuple[Any, ...], Any]] = deque()
        for piece in pieces:
            under_way.append((piece, schedule(piece)))
            if len(under_way) > 4 * effort.workers:
                yield result(*under_way.popleft())
        while under_way:
            yield result(*under_way.popleft())


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


@contextmanager
def _pool(workers: int) -> Iterator[Any]:
    pool = ProcessPool(max_workers=workers, max_tasks=PIECES_PER_WORKER, context=_Context())
    try:
        yield pool
        pool.close()
    except BaseException:
        pool.stop()
        raise
    finally:
        pool.join()
