"""Processor time per instance of each task in one process, and an estimate for the whole task.

    python -m benchmarks.cost specs/perception specs/prediction --tried 16

Units are generated as by `generate`, without the first instance, which starts engines. Unlike `generate --dry-run`, it
measures processor time, which depends little on other load.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

os.environ.setdefault("LP_NUM_THREADS", "0")

from wmspec.api.generating import plan_dataset
from wmspec.dataset.build.batching import batches
from wmspec.dataset.build.generate import job_of
from wmspec.dataset.build.plan import Plan, Task
from wmspec.dataset.build.worker import CacheStats, Job, make_instances
from wmspec.runtime.workers.pool import PoolConfig

#: The most pieces generated of a unit.
PIECES = 16


def cost(job: Job, task: Task, seed: int, tried: int) -> tuple[float, int, CacheStats]:
    """Return the seconds for instances spread over the task, their number, and the cache statistics."""
    every, seconds, made, shared = list(batches(task.spec, seed, task.indices)), 0.0, 0, CacheStats()
    make_instances(job, task.spec.name, every[-1][0])
    for number in range(0, len(every) - 1, max(1, len(every) * 4 // tried)):
        for piece in every[number][:PIECES]:
            began = time.process_time()
            shared += make_instances(job, task.spec.name, piece).shared
            seconds += time.process_time() - began
            made += len(piece)
        if made >= tried:
            break
    return seconds, made, shared


def main() -> None:
    """Run and report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("specs", nargs="+", type=Path)
    parser.add_argument("--tried", type=int, default=16, help="instances of each task, at least")
    options = parser.parse_args()
    plan: Plan = plan_dataset(options.specs, lambda _: None, backend="mujoco")
    job, whole = job_of(plan, PoolConfig(1, 300)), 0.0
    for task in plan.tasks:
        seconds, made, shared = cost(job, task, plan.seed, options.tried)
        hours = seconds / made * len(task.indices) / 3600
        whole += hours
        print(f"{task.spec.name:26} {seconds / made * 1000:6.0f} ms  {hours:5.2f} h of a core; of {made}: {shared}")
    print(f"all: {whole:.1f} hours of a core")


if __name__ == "__main__":
    main()
