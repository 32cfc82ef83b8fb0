"""Cost per instance of each task, compared with loops in a bare engine (`benchmarks.loops`).

    python -m benchmarks.native specs/perception specs/prediction [--backend mujoco] [--tried 8] [--size 384]

The loop executes the same episodes (truth, counterfactuals, perturbations) of every instance separately, and draws as
many pictures. It creates no stages or questions and checks nothing. wmspec generates whole units, as `generate` does.
Processor times, measured alternately.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

os.environ.setdefault("LP_NUM_THREADS", "0")
os.environ.setdefault("MUJOCO_GL", "egl")

from benchmarks.cost import cost
from benchmarks.loops import LOOPS
from wmspec.api.generating import plan_dataset
from wmspec.compile.design.design import Design
from wmspec.dataset.build.generate import job_of
from wmspec.runtime.caches.cache_keys import look_key, physics_key, shot_key
from wmspec.runtime.caches.render_cache import RenderCache
from wmspec.runtime.caches.trace_cache import TraceCache
from wmspec.runtime.questions.ask import ask
from wmspec.runtime.questions.runs import EnginePair
from wmspec.runtime.workers.pool import PoolConfig
from wmspec.sim.scene.model import Frame, Scene, Shot, Trace


class Traces(TraceCache):
    """An executor that records each physics once per instance, as a hand-written loop would run it."""

    def __init__(self, engine: str) -> None:
        super().__init__(engine)
        self.noted: dict[bytes, Scene] = {}

    def trace(self, scene: Scene) -> Trace:
        """Return the trace of a scene."""
        self.noted.setdefault(physics_key(scene), scene)
        return super().trace(scene)


class Pictures(RenderCache):
    """A renderer that records which pictures belong to which physics."""

    def __init__(self, engine: str, size: int) -> None:
        super().__init__(engine, size, size)
        self.noted: dict[bytes, set[tuple[bytes, bytes]]] = {}

    def draw(self, scene: Scene, shot: Shot, *, depth: bool = False) -> Frame:
        """Return the picture of a scene from a camera."""
        self.noted.setdefault(physics_key(scene), set()).add((look_key(scene), shot_key(shot)))
        return super().draw(scene, shot, depth=depth)


def episodes(design: Design, index: int, engine: str, size: int) -> list[tuple[Scene, int]]:
    """Return the episodes of an instance with their numbers of pictures."""
    traces, pictures = Traces(engine), Pictures(engine, size)
    ask(design, index, EnginePair(traces, pictures))
    pictures.close()
    return [(scene, len(pictures.noted.get(key, ()))) for key, scene in traces.noted.items()]


def main() -> None:
    """Print both times and their ratio for each task."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("specs", nargs="+", type=Path)
    parser.add_argument("--backend", choices=LOOPS, default="mujoco")
    parser.add_argument("--tried", type=int, default=8, help="instances of each task, at least")
    parser.add_argument("--native", type=int, default=3, help="of these by the loop")
    parser.add_argument("--size", type=int, default=384)
    options = parser.parse_args()
    plan = plan_dataset(options.specs, lambda _: None, backend=options.backend, size=options.size)
    job = job_of(plan, PoolConfig(1, 300))
    for task in plan.tasks:
        seconds, made, _ = cost(job, task, plan.seed, options.tried)
        design, bare, drawn = Design(task.spec, plan.seed), 0.0, 0
        for index in task.indices[:: max(1, len(task.indices) // options.native)][: options.native]:
            every = episodes(design, index, options.backend, options.size)
            began = time.process_time()
            LOOPS[options.backend](every, options.size)
            bare += time.process_time() - began
            drawn += sum(pictures for _, pictures in every)
        ours, loop = 1e3 * seconds / made, 1e3 * bare / options.native
        print(
            f"{task.spec.name:26} {ours:6.0f} ms, the loop {loop:6.0f} ms: {loop / ours:5.2f} times as fast; "
            f"{drawn / options.native:.1f} pictures",
            flush=True,
        )


if __name__ == "__main__":
    main()
