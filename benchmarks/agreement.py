"""Processor time of questions that three engines answer, relative to the time in MuJoCo alone.

    python -m benchmarks.agreement [--tasks collide,drop] [--instances 8] [--size 384] [--repeats 3]

Each task is generated in the first engine alone and in all of them, in turn, each time in a new process; the least of
the repeated times counts. Processor time excludes the start of the process, the check of the spec and the first group,
which starts the engines.
"""

from __future__ import annotations

import argparse
import gc
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from statistics import fmean
from typing import Any

os.environ.setdefault("LP_NUM_THREADS", "0")

from wmspec.api import load_all
from wmspec.api.generating import plan_dataset
from wmspec.dataset.build.batching import batches
from wmspec.dataset.build.generate import job_of
from wmspec.dataset.build.worker import Outcome, make_instances
from wmspec.runtime.workers.pool import PoolConfig

#: Tasks of all kinds: nothing moves, bodies follow paths, free bodies roll, fall, topple and collide, arms and a car.
TASKS = (
    "color_tabletop", "count_room", "direction_tabletop", "onset_sliding", "collide", "drop", "domino_row", "arm_push",
    "arm_drop", "drive",
)  # fmt: skip


def main() -> None:
    """Measure every task, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tasks", default=",".join(TASKS))
    parser.add_argument("--instances", type=int, default=8, help="of each task, at least; groups are whole")
    parser.add_argument("--size", type=int, default=384, help="pixels on a side")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--engines", default="mujoco,pybullet,sapien")
    parser.add_argument("--measure", default="", metavar="SPEC", help="measure one task of a spec, and print JSON")
    options = parser.parse_args()
    if options.measure:
        chosen = measured(options.measure, options.tasks, options.engines, options.instances, options.size)
        print(json.dumps(chosen))
        return
    specs = {task.name: str(task.path) for task in load_all(tell=lambda _: None)}
    alone, *_ = options.engines.split(",")
    print(f"{'task':22}{'instances':>10}{alone:>10}{'all':>10}{'ratio':>8}{'kept':>12}")
    ratios = []
    for task in options.tasks.split(","):
        if task not in specs:
            sys.exit(f"there is no task `{task}`")
        pairs = [
            [_in_process(options, specs[task], task, engines) for engines in (alone, options.engines)]
            for _ in range(options.repeats)
        ]
        one, three = (min(runs, key=lambda run: run["seconds"]) for runs in zip(*pairs, strict=True))
        ratios.append(three["seconds"] / one["seconds"])
        kept = f"{one['kept']} / {three['kept']}"
        seconds = f"{one['seconds']:10.2f}{three['seconds']:10.2f}"
        print(f"{task:22}{one['instances']:10}{seconds}{ratios[-1]:8.2f}{kept:>12}", flush=True)
    print(
        f"mean {fmean(ratios):.2f}, largest {max(ratios):.2f} (seconds of a processor; questions kept: {alone} / all)"
    )


def _in_process(options: argparse.Namespace, spec: str, task: str, engines: str) -> dict[str, Any]:
    """Return the measurement of a task in a new process."""
    numbers = ["--instances", str(options.instances), "--size", str(options.size)]
    command = [sys.executable, "-m", "benchmarks.agreement", "--measure", spec, "--tasks", task, "--engines", engines]
    done = subprocess.run([*command, *numbers], check=True, stdout=subprocess.PIPE, text=True)
    measurement: dict[str, Any] = json.loads(done.stdout)
    return measurement


def measured(spec: str, name: str, engines: str, instances: int, size: int) -> dict[str, Any]:
    """Return processor time (s), number of instances and number of kept questions of a task."""
    task = next(task for task in load_all(Path(spec), tell=lambda _: None) if task.name == name)
    plan = plan_dataset([task], lambda _: None, backend=engines, per_task=2 * instances, size=size)
    job, (planned,) = job_of(plan, PoolConfig(1, 300)), plan.tasks
    every = [piece for unit in batches(planned.spec, plan.seed, planned.indices) for piece in unit]
    gc.set_threshold(100_000, 20, 100)  # as in a worker
    make_instances(job, name, every[-1])
    outcomes: list[Outcome] = []
    began = time.process_time()
    for piece in every[:-1]:
        if len(outcomes) >= instances:
            break
        outcomes += make_instances(job, name, piece).outcomes
    seconds = time.process_time() - began
    return {"seconds": seconds, "instances": len(outcomes), "kept": sum(len(o.rows) for o in outcomes)}


if __name__ == "__main__":
    main()
