"""Executes scenes, once per physics key: colours do not change a trajectory."""

from __future__ import annotations

from collections import OrderedDict

from wmspec.runtime.caches.cache_keys import physics_key
from wmspec.runtime.engines.registry import backend
from wmspec.sim.scene.model import Scene, Trace


class TraceCache:
    """Executes scenes in one engine and caches the most recent traces (about 250 kB each) by physics key.

    `requests` counts requested traces, `executed` the executed episodes.
    """

    def __init__(self, engine: str, remembered: int = 128) -> None:
        self.engine = engine
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
