"""Workers on a Ray cluster: each is an actor with a local worker process.

Ray schedules jobs and recovers from lost machines. Timeouts and failures of jobs are handled as on one machine.
Therefore the same jobs give the same results and failures.
"""

from __future__ import annotations

import logging
import socket
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, nullcontext
from importlib import import_module
from typing import Any, TypeVar

from wmspec.core.diagnostics import WmsError
from wmspec.core.signals import defer_signals
from wmspec.runtime.workers.pool import (
    MAX_RETRIES,
    JobFailure,
    LocalWorkers,
    PoolConfig,
    PoolJob,
    result,
)

T = TypeVar("T")

#: Timeout (s) for a machine's versions; it imports wmspec for the first time.
STARTUP_TIMEOUT = 300.0


@contextmanager
def ray_cluster(address: str, workers: int | None, timeout: float, versions: Mapping[str, str]) -> Iterator[PoolConfig]:
    """Provide the workers of the cluster at `address` ("auto": this machine's), or of a new one if it is empty.

    `workers` is their number; None means one per processor. `versions` are those of wmspec and the engines, which
    determine the results. Raises WmsError if Ray or the cluster is missing, or a machine has other versions.
    """
    with nullcontext() if _ray().is_initialized() else _connected(address, workers):
        _require_versions(versions)
        processors = int(_ray().cluster_resources().get("CPU", 0))
        yield PoolConfig(workers or max(1, processors), timeout, RayWorkers)


class RayWorkers:
    """One worker of the cluster, replaced if its machine is lost."""

    def __init__(self) -> None:
        self._losses = 0
        self._begin()

    def take(self, job: PoolJob, others: Iterable[PoolJob]) -> None:  # noqa: ARG002  as `Workers` has it
        """Submit a job."""
        with defer_signals():
            job.future = self._actor.do.remote(job.work, job.piece, job.timeout).future()

    def done(self, jobs: Sequence[PoolJob]) -> bool:
        """Whether the first job is done; if its machine is lost, restart it on another.

        This must not wait for the new machine, which may become available only after other jobs finish.
        """
        if not jobs[0].future.done():
            return False
        if not _is_node_lost(jobs[0]) or self._losses == MAX_RETRIES:
            return True
        self._losses += 1
        self._renew(jobs)
        return False

    def result(self, job: PoolJob, others: Iterable[PoolJob]) -> Any:  # noqa: ARG002
        """Return the result of a finished job. Raises its error, or BrokenProcessPool if all machines were lost."""
        from ray.exceptions import RayError, RayTaskError

        self._losses = 0
        try:
            return job.future.result()
        except RayTaskError as error:
            raise error.cause from None
        except RayError:
            raise BrokenProcessPool from None

    def finish(self) -> None:
        """Release the processor."""
        self.stop()

    def stop(self) -> None:
        """Kill the worker."""
        with defer_signals():
            _ray().kill(self._actor)

    def _begin(self) -> None:
        with defer_signals():
            self._actor: Any = _remote(_Actor, num_cpus=1).remote()

    def _renew(self, jobs: Iterable[PoolJob]) -> None:
        undone = [job for job in jobs if not job.future.done() or _is_node_lost(job)]
        self.stop()
        self._begin()
        for job in undone:
            self.take(job, ())


class _Actor:
    """The actor that runs on a machine of the cluster."""

    def __init__(self) -> None:
        self._workers = LocalWorkers(1)

    def do(self, work: Callable[..., T], piece: tuple[Any, ...], timeout: float) -> T | JobFailure:
        """Return the result of a job, computed as without a cluster."""
        job = PoolJob(work, piece, timeout)
        self._workers.take(job, ())
        done: T | JobFailure = result(job, (), self._workers)
        return done


def _is_node_lost(job: PoolJob) -> bool:
    """True if a finished job failed because its node was lost."""
    from ray.exceptions import RayError, RayTaskError

    error = job.future.exception()
    return isinstance(error, RayError) and not isinstance(error, RayTaskError)


@contextmanager
def _connected(address: str, workers: int | None) -> Iterator[None]:
    """Connect to a cluster within the context. Raises WmsError if there is none."""
    with ThreadPoolExecutor(1) as thread:  # processes of Ray end with the thread that starts them
        try:
            _start_ray(thread, address, workers)
            yield
        finally:
            with defer_signals():
                _ray().shutdown()


def _start_ray(thread: ThreadPoolExecutor, address: str, workers: int | None) -> None:
    """Initialize Ray in a thread: in the main thread it handles SIGTERM, and a signal could interrupt the start."""
    ray = _ray()
    if not address and any(map(str.isspace, sys.executable)):
        raise WmsError(
            f"Ray cannot start workers by `{sys.executable}`, whose path has a space",
            help="install wmspec where there is none, or work without Ray",
        )
    quiet = {"log_to_driver": False, "logging_level": logging.ERROR, "include_dashboard": None if address else False}
    try:
        _require_reachable(address)
        with defer_signals():
            thread.submit(ray.init, address or "local", num_cpus=None if address else workers, **quiet).result()
    except Exception as error:  # Ray raises plain ones, such as for a node that starts too slowly
        reason = " ".join(str(error).split())[:300].rstrip(".")
        raise WmsError(
            f"there is no Ray cluster at `{address}`: {reason}" if address else f"Ray does not start: {reason}",
            help="start one with `ray start --head`, or leave --address out to have one on this machine alone",
        ) from error


def _require_reachable(address: str) -> None:
    """Raise OSError or ValueError if an address does not respond; Ray would take minutes to report it."""
    if address and address != "auto":
        host, colon, port = address.rpartition(":")
        if not (host and colon and port.isdecimal()) or "//" in host:
            raise ValueError("an address is auto, or HOST:PORT of the head of a cluster that this machine is a part of")
        socket.create_connection((host.strip("[]"), int(port)), timeout=10).close()


def _require_versions(versions: Mapping[str, str]) -> None:
    """Raise WmsError unless every machine of the cluster has these versions."""
    from ray.exceptions import RayError
    from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

    ray = _ray()
    nodes = {node["NodeID"]: node["NodeManagerHostname"] for node in ray.nodes() if node["Alive"]}
    pending = {
        node: _remote(_versions, num_cpus=0, scheduling_strategy=NodeAffinitySchedulingStrategy(node, soft=False))
        for node in nodes
    }
    # Not `ray.get`, which changes the exit code if a signal arrives meanwhile.
    answers = {node: there.remote(tuple(versions)).future() for node, there in pending.items()}
    for node, answer in answers.items():
        try:
            there = answer.result(timeout=STARTUP_TIMEOUT)
        except (RayError, TimeoutError) as error:
            reason = " ".join(str(error).split())[-300:] or f"it has not answered for {STARTUP_TIMEOUT:g} s"
            raise WmsError(
                f"the machine {nodes[node]} of the cluster cannot run wmspec: {reason}",
                help="install the same wmspec, with the same engines, on every machine",
            ) from error
        for name, version in versions.items():
            if there[name] != version:
                raise WmsError(
                    f"the machine {nodes[node]} of the cluster has {name} {there[name]}, and this one {version}",
                    help="install the same versions on every machine: others would make other data",
                )


def _versions(names: Iterable[str]) -> dict[str, str]:
    from wmspec.runtime.engines.registry import version_of

    return {name: version_of(name) for name in names}


def _remote(what: Any, **options: Any) -> Any:
    """Return a function or class as Ray's; limits Mesa, which would start a thread per core in every worker."""
    return _ray().remote(runtime_env={"env_vars": {"LP_NUM_THREADS": "0"}}, **options)(what)


def _ray() -> Any:
    """Return the module ray, which has incomplete types. Raises WmsError if it is not installed."""
    try:
        return import_module("ray")
    except ImportError:
        raise WmsError("there is no Ray here", help="install it: pip install 'wmspec[ray]'") from None
