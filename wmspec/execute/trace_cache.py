"""Executing scenes, each physics once: colour does not change a trajectory."""

from __future__ import annotations

import hashlib
import pickle
from collections import OrderedDict
from dataclasses import replace

from wmspec.execute.backends import backend
from wmspec.scene.model import Scene, Surface, Trace

_PLAIN = Surface()


def physics_key(scene: Scene) -> str:
    """What physics reads of a scene, as a hash: two scenes with the same key have the same trace."""
    bodies = tuple(replace(b, geoms=tuple(replace(g, surface=_PLAIN) for g in b.geoms)) for b in scene.bodies)
    linked = (scene.joints, scene.filtered)
    read = (scene.gravity.tobytes(), scene.actions, bodies, linked, scene.duration, scene.rate)
    return hashlib.blake2b(pickle.dumps(read, protocol=4), digest_size=16).hexdigest()


class TraceCache:
    """Executes scenes in one engine and remembers the latest traces by what physics reads."""

    def __init__(self, engine: str, remembered: int = 64) -> None:
        self.engine = engine
        self._remembered = remembered
        self._traces: OrderedDict[str, Trace] = OrderedDict()

    def trace(self, scene: Scene) -> Trace:
        """The trace of a scene, executed now or before. Raises EngineError if the engine fails on it."""
        key = physics_key(scene)
        if key not in self._traces:
            self._traces[key] = backend(self.engine).execute(scene)
            if len(self._traces) > self._remembered:
                self._traces.popitem(last=False)
        self._traces.move_to_end(key)
        return self._traces[key]
