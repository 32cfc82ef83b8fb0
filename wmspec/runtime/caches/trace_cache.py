"""Executing scenes, each physics once: colour does not change a trajectory."""

from __future__ import annotations

from wmspec.core.memoize import LRU
from wmspec.runtime.caches.cache_keys import physics_key
from wmspec.runtime.engines.registry import backend
from wmspec.sim.scene.model import Scene, Trace


class TraceCache:
    """Executes scenes in one engine and remembers the latest traces (some 250 kB each) by what physics reads.

    `asked` is how many traces it was asked for, `executed` how many episodes that took.
    """

    def __init__(self, engine: str, remembered: int = 128) -> None:
        self.engine = engine
        self.asked = self.executed = 0
        self._traces: LRU[bytes, Trace] = LRU(remembered)

    def trace(self, scene: Scene) -> Trace:
        """The trace of a scene, executed now or before. Raises EngineError if the engine fails on it."""
        self.asked += 1
        return self._traces.get(physics_key(scene), lambda: self._execute(scene))

    def _execute(self, scene: Scene) -> Trace:
        self.executed += 1
        return backend(self.engine).execute(scene)
