"""How large in the pictures is what a question names? A table of docs/benchmarks/pictures.md.

python -m tools.composition [SPEC...] [--count 30] [--size 256]

Instances are spread over each task and executed in MuJoCo. `together` is the share of a picture covered by all objects
of the first question, or by movable objects if it names none. `wide` is the share of the frame width that each
visible object covers: median and quartiles. `cut` is the percentage of objects cut off by an edge of the frame.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import wmspec
from tools.reference import table
from wmspec.api.episode import executor
from wmspec.api.rendering import renderer_of
from wmspec.api.task import Task
from wmspec.compile.design.about import referenced_objects
from wmspec.runtime.questions.model import Reject
from wmspec.runtime.questions.runs import EnginePair, execute
from wmspec.runtime.questions.views import views_of
from wmspec.sim.scene.model import Array

HEADS = ("task", "together", "wide each", "quarters", "cut")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("specs", nargs="*", type=Path, default=[Path("specs/perception")])
    parser.add_argument("--count", type=int, default=30, help="instances of each task")
    parser.add_argument("--size", type=int, default=256, help="pixels on a side")
    chosen = parser.parse_args()
    for line in table(HEADS, (row(t, chosen.count, chosen.size) for p in chosen.specs for t in wmspec.load_all(p))):
        print(line, flush=True)


def row(task: Task, count: int, size: int) -> tuple[str, ...]:
    """Return the row of a task."""
    together, wide, cut = (np.concatenate(part) for part in zip(*_measured(task, count, size), strict=True))
    low, middle, high = 100 * np.percentile(wide, (25, 50, 75))
    return (
        f"`{task.name}`",
        f"{100 * np.median(together):.1f} %",
        f"{middle:.0f} %",
        f"{low:.0f} to {high:.0f}",
        f"{100 * cut.mean():.0f}",
    )


def _measured(task: Task, count: int, size: int) -> Iterator[tuple[Array, Array, Array]]:
    """Yield per instance: covered share of each picture, and width and cut-off flag of each object."""
    pair = EnginePair(executor("mujoco"), renderer_of("mujoco", size=size))
    for instance in task.sample(count):
        try:
            run = execute(task.design, instance.drawn, None, pair)
        except Reject:
            continue
        referenced = referenced_objects(task.spec.questions[0], run.values)
        bodies = list(enumerate(run.scene.bodies))
        numbers = [i for i, b in bodies if b.name in referenced] or [i for i, b in bodies if b.motion != "static"]
        pictures = [run.draw(camera, time, pair).ids for camera, time in views_of(task.spec, run.values)]
        masks = [ids == i for ids in pictures for i in numbers if (ids == i).any()]
        yield (
            np.array([np.isin(ids, numbers).mean() for ids in pictures]),
            np.array([np.ptp(np.flatnonzero(mask.any(axis=0))) + 1 for mask in masks]) / size,
            np.array([mask[[0, -1]].any() or mask[:, [0, -1]].any() for mask in masks]),
        )


if __name__ == "__main__":
    main()
