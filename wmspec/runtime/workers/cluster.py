"""Workers on the machines of a Ray cluster: each is an actor, with a worker process of its own where it is.

Ray says where work is done, and what to do when a machine is lost; what a piece of work may cost is decided there as it
is here. So the same pieces give the same results, and the same of them fail for the same reasons.
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
from wmspec.runtime.workers.pool import PATIENCE, Effort, Job, LocalWorkers, Lost, result, undisturbed

T = TypeVar("T")

#: The seconds for which a machine may be asked for its versions: it imports wmspec for the first time.
FIRST = 300.0


@contextmanager
def ray_cluster(address: str, workers: int | None, timeout: float, versions: Mapping[str, str]) -> Iterator[Effort]:
    """What a cluster can do: that at `address` ("auto": the one of this machine), or one started here if it is empty.

    `workers`: so many, or one for each of its processors. `versions`: those of wmspec and engines, which decide what
    comes out. Raises WmsError if there is no Ray, no cluster, or a machine of other versions.
    """
    with nullcontext() if _ray().is_initialized() else _joined(address, workers):
        _check(versions)
        processors = int(_ray().cluster_resources().get("CPU", 0))
        yield Effort(workers or max(1, processors), timeout, RayWorkers)


class RayWorkers:
    """One worker of the cluster, and another in its place if its machine is lost."""

    def __init__(self) -> None:
        self._losses = 0
        self._begin()

    def take(self, job: Job, others: Iterable[Job]) -> None:  # noqa: ARG002  as `Workers` has it
        """Have the job done."""
        with undisturbed():
            job.future = self._actor.do.remote(job.work, job.piece, job.timeout).future()

    def done(self, jobs: Sequence[Job]) -> bool:
        """Whether the first of its jobs is done; where its machine is lost, another takes over.

        Nobody may wait here for that one: it may have to wait until the others have no more to do.
        """
        if not jobs[0].future.done():
            return False
        if not _gone(jobs[0]) or self._losses == PATIENCE:
            return True
        self._losses += 1
        self._renew(jobs)
        return False

    def result(self, job: Job, others: Iterable[Job]) -> Any:  # noqa: ARG002
        """What a job that is done gives. Raises what it raises, BrokenProcessPool if all its machines were lost."""
        from ray.exceptions import RayError, RayTaskError

        self._losses = 0
        try:
            return job.future.result()
        except RayTaskError as error:
            raise error.cause from None
        except RayError:
            raise BrokenProcessPool from None

    def finish(self) -> None:
        """Let another have its processor."""
        self.stop()

    def stop(self) -> None:
        """End it, whatever it is doing."""
        with undisturbed():
            _ray().kill(self._actor)

    def _begin(self) -> None:
        with undisturbed():
            self._actor: Any = _remote(_Actor, num_cpus=1).remote()

    def _renew(self, jobs: Iterable[Job]) -> None:
        undone = [job for job in jobs if not job.future.done() or _gone(job)]
        self.stop()
        self._begin()
        for job in undone:
            self.take(job, ())


class _Actor:
    """What runs on a machine of the cluster."""

    def __init__(self) -> None:
        self._workers = LocalWorkers(1)

    def do(self, work: Callable[..., T], piece: tuple[Any, ...], timeout: float) -> T | Lost:
        """The piece of work, as it is done without a cluster."""
        job = Job(work, piece, timeout)
        self._workers.take(job, ())
        done: T | Lost = result(job, (), self._workers)
        return done


def _gone(job: Job) -> bool:
    """Whether a job that is over came to nothing, since its worker, or what that had made, is gone with its machine."""
    from ray.exceptions import RayError, RayTaskError

    error = job.future.exception()
    return isinstance(error, RayError) and not isinstance(error, RayTaskError)


@contextmanager
def _joined(address: str, workers: int | None) -> Iterator[None]:
    """Being a part of a cluster. Raises WmsError if there is none."""
    with ThreadPoolExecutor(1) as thread:  # what Ray starts ends with the thread that starts it
        try:
            _join(thread, address, workers)
            yield
        finally:
            with undisturbed():
                _ray().shutdown()


def _join(thread: ThreadPoolExecutor, address: str, workers: int | None) -> None:
    """Begin Ray in a thread: in the main one it takes SIGTERM for itself, and a signal would leave it half begun."""
    ray = _ray()
    if not address and any(map(str.isspace, sys.executable)):
        raise WmsError(
            f"Ray cannot start workers by `{sys.executable}`, whose path has a space",
            help="install wmspec where there is none, or work without Ray",
        )
    quiet = {"log_to_driver": False, "logging_level": logging.ERROR, "include_dashboard": None if address else False}
    try:
        _answers(address)
        with undisturbed():
            thread.submit(ray.init, address or "local", num_cpus=None if address else workers, **quiet).result()
    except (ValueError, RuntimeError, OSError) as error:
        reason = " ".join(str(error).split())[:300].rstrip(".")
        raise WmsError(
            f"there is no Ray cluster at `{address}`: {reason}" if address else f"Ray does not start: {reason}",
            help="start one with `ray start --head`, or leave --address out to have one on this machine alone",
        ) from error


def _answers(address: str) -> None:
    """Raise OSError or ValueError if nobody is at an address, which takes Ray minutes to say."""
    if address and address != "auto":
        host, colon, port = address.rpartition(":")
        if not (host and colon and port.isdecimal()) or "//" in host:
            raise ValueError("an address is auto, or HOST:PORT of the head of a cluster that this machine is a part of")
        socket.create_connection((host.strip("[]"), int(port)), timeout=10).close()


def _check(versions: Mapping[str, str]) -> None:
    """Raise WmsError unless every machine of the cluster has these versions."""
    from ray.exceptions import RayError
    from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

    ray = _ray()
    nodes = {node["NodeID"]: node["NodeManagerHostname"] for node in ray.nodes() if node["Alive"]}
    asked = {
        node: _remote(_versions, num_cpus=0, scheduling_strategy=NodeAffinitySchedulingStrategy(node, soft=False))
        for node in nodes
    }
    # Not by `ray.get`, which gives another exit code to who is told to end meanwhile.
    answers = {node: there.remote(tuple(versions)).future() for node, there in asked.items()}
    for node, answer in answers.items():
        try:
            there = answer.result(timeout=FIRST)
        except (RayError, TimeoutError) as error:
            reason = " ".join(str(error).split())[-300:] or f"it has not answered for {FIRST:g} s"
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
    """A function or class as Ray's; Mesa would start a thread per core in every worker."""
    return _ray().remote(runtime_env={"env_vars": {"LP_NUM_THREADS": "0"}}, **options)(what)


def _ray() -> Any:
    """Ray, which is half typed. Raises WmsError if it is not installed."""
    try:
        return import_module("ray")
    except ImportError:
        raise WmsError("there is no Ray here", help="install it: pip install 'wmspec[ray]'") from None
