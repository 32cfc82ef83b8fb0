"""Executes scenes, once per physics key: colours do not change a trajectory."""

from __future__ import annotations

from wmspec.core.memoize import LRU
from wmspec.runtime.caches.cache_keys import physics_key
from wmspec.runtime.engines.registry import backend
from wmspec.sim.scene.model import Scene, Trace

#: Cache size of traces (bytes). A trace has 0.1 to 8 MB.
MAX_TRACE_BYTES = 96_000_000


class TraceCache:
    """Executes scenes in one engine and caches the most recent traces by physics key.

    `requests` counts requested traces, `executed` the executed episodes.
    """

    def __init__(self, engine: str, remembered: int = MAX_TRACE_BYTES) -> None:
        self.engine = engine
        self.requests = self.executed = 0
        self._traces: LRU[bytes, Trace] = LRU(remembered, weigh=_bytes)

    def trace(self, scene: Scene) -> Trace:
        """Return the trace of a scene, cached if possible. Raises EngineError if the engine fails."""
        self.requests += 1
        return self._traces.get(physics_key(scene), lambda: self._execute(scene))

    def _execute(self, scene: Scene) -> Trace:
        self.executed += 1
        return backend(self.engine).execute(scene)


def _bytes(trace: Trace) -> int:
    arrays = trace.time, trace.position, trace.orientation, trace.linear_velocity, trace.angular_velocity
    return sum(array.nbytes for array in arrays)
