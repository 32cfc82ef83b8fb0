"""Executes scenes, once per physics key: colours do not change a trajectory."""

from __future__ import annotations

from wmspec.core.memoize import LRU
from wmspec.runtime.caches.cache_keys import physics_key
from wmspec.runtime.engines.registry import backend
from wmspec.sim.scene.model import Scene, Trace


class TraceCache:
    """Executes scenes in one engine and caches the most recent traces (about 250 kB each) by physics key.

    `requests` counts requested traces, `executed` the executed episodes.
    """

    def __init__(self, engine: str, remembered: int = 128) -> None:
        self.engine = engine
<<<<<<< HEAD
        self.requests = self.executed = 0
        self._remembered = remembered
        self._traces: OrderedDict[bytes, Trace] = OrderedDict()

    def trace(self, scene: Scene) -> Trace:
        """Return the trace of a scene, cached if possible. Raises EngineError if the engine fails."""
        key = physics_key(scene)
        self.requests += 1
        if key not in self._traces:
            self.executed += 1
            self._traces[key] = backend(self.engine).execute(scene)
            if len(self._traces) > self._remembered:
                self._traces.popitem(last=False)
        self._traces.move_to_end(key)
        return self._traces[key]
=======
        self.asked = self.executed = 0
        self._traces: LRU[bytes, Trace] = LRU(remembered)

    def trace(self, scene: Scene) -> Trace:
        """The trace of a scene, executed now or before. Raises EngineError if the engine fails on it."""
        self.asked += 1
        return self._traces.get(physics_key(scene), lambda: self._execute(scene))

    def _execute(self, scene: Scene) -> Trace:
        self.executed += 1
        return backend(self.engine).execute(scene)
>>>>>>> main
