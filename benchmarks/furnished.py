"""Render cost of furnished places, compared with the bare places of an earlier commit and its code.

    python -m benchmarks.furnished CHECKOUT [--size 256] [--frames 16] [--engines mujoco,pybullet,sapien]

CHECKOUT is a clone at that commit, such as 69255fb. The same three objects are in its `room` and on its `tabletop`, and
in each place of `grounds` and `tables` here, seen by the camera `front`. All objects move from frame to frame. Two
processes, one per version, alternate frame by frame and so share other load. Reports the median processor time of a
frame with ids and depth.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import wmspec
from tools.reference import table

HERE = Path(__file__).parents[1]
BEFORE = {"room": "floor", "tabletop": "table"}
#: The places of either library, by the beginning of the names of what only they have.
NOW = {
    "grounds": {"lounge": "living room", "nursery": "nursery", "hall": "hall", "terrace": "terrace"},
    "tables": {"kitchen": "kitchen", "office": "office", "workshop": "workshop", "laboratory": "laboratory"},
}
THINGS = """
use {library}{called}

task seen : custom {{
  factor tone in [red, blue]
  nuisance x in -1 cm .. 1 cm
  repeat 24
  object ball {{ shape: sphere  size: 14 cm  color: tone  on: {ground} at (-20 cm + x, -10 cm) }}
  object can  {{ shape: cylinder  size: 12 cm  color: green  on: {ground} at (0, 10 cm) }}
  object block {{ shape: cube  size: 12 cm  color: yellow  on: {ground} at (20 cm, -5 cm) }}
  action go = glide(ball, direction: right, speed: 10 cm/s) for 1 s
  observe {camera} at [0 s]
  question "Which colour has the ball?" {{
    options [red, blue]
    answer  ball.color
  }}
}}
"""
#: By the earlier code: the stage of a spec.
COMPILE = """
import sys
from pathlib import Path
from wmspec.cli.common import one_task
from wmspec.compile.design.design import Design
from wmspec.compile.stage.episode import document
from wmspec.compile.stage.layers import compose
task = one_task(Path(sys.argv[1]))
compose(document(task, Design(task, 0)[0])).Flatten().Export(sys.argv[2])
"""
#: By either code: the processor time (s) of a frame of the stage of a given number.
DRAW = """
import importlib, sys, time
from dataclasses import replace
import numpy as np
from pxr import Usd
try:
    import wmspec.sim.usd.schema
    from wmspec.sim.usd import read
except ImportError:
    import wmspec.sim.scene.schema
    from wmspec.sim.scene.read import read
from wmspec.sim.scene.model import Shot

backend, size = importlib.import_module(f"wmspec.backends.{sys.argv[1]}"), int(sys.argv[2])
scenes = [read(Usd.Stage.Open(path)) for path in sys.argv[3:]]
eyes = [next(one.name for one in scene.cameras if one.name.endswith("front")) for scene in scenes]
renderers = [backend.renderer(scene, size, size) for scene in scenes]
print("ready", flush=True)
for line in sys.stdin:
    which, frame = map(int, line.split())
    step = np.array([0.0, 0.002 * frame, 0.0])
    poses = [
        replace(b.pose, position=b.pose.position + step * (b.motion != "static")) for b in scenes[which].bodies
    ]
    begin = time.process_time()
    renderers[which].draw(Shot(eyes[which], poses), depth=True)
    print(time.process_time() - begin, flush=True)
"""


def main() -> None:
    """Print a table for each engine."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("checkout", type=Path)
    parser.add_argument("--size", type=int, default=256, help="pixels on a side")
    parser.add_argument("--frames", type=int, default=16)
    parser.add_argument("--engines", default="mujoco,pybullet,sapien")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        before, now = list(_before(chosen.checkout.resolve(), Path(folder))), list(_now(Path(folder)))
        for engine in chosen.engines.split(","):
            sides = [
                Side(code, engine, chosen.size, [path for _, _, path in stages])
                for code, stages in ((chosen.checkout.resolve(), before), (HERE, now))
            ]
            old, new = taken(sides, chosen.frames)
            base = {where: cost for (where, _, _), cost in zip(before, old, strict=True)}
            rows = [
                (place, f"{base[where]:.1f}", f"{cost:.1f}", f"{cost / base[where]:.2f}")
                for (where, place, _), cost in zip(now, new, strict=True)
            ]
            for line in table((f"{engine}, {chosen.size} px", "before (ms)", "now (ms)", "ratio"), iter(rows)):
                print(line, flush=True)
            for where in NOW:
                mean = np.mean([cost for (one, _, _), cost in zip(now, new, strict=True) if one == where])
                print(f"mean of {where}: {mean / base[where]:.2f} times", flush=True)


class Side:
    """A process that renders frames of stages with the code of a checkout."""

    def __init__(self, code: Path, engine: str, size: int, stages: list[Path]) -> None:
        environment = {**os.environ, "PYTHONPATH": str(code)}
        self.count = len(stages)
        self._process = subprocess.Popen(
            [sys.executable, "-c", DRAW, engine, str(size), *map(str, stages)],
            cwd=code,
            env=environment,
            text=True,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        self._answer()

    def draw(self, which: int, frame: int) -> float:
        """Return the processor time of a frame (ms)."""
        assert self._process.stdin is not None
        print(which, frame, file=self._process.stdin, flush=True)
        return 1000 * float(self._answer())

    def close(self) -> None:
        """Stop the process."""
        self._process.communicate()

    def _answer(self) -> str:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError("a process that draws has ended")
        return line


def taken(sides: list[Side], frames: int) -> list[list[float]]:
    """Return the median time (ms) of each stage per side, alternating frames; the first two do not count."""
    spent: list[list[list[float]]] = [[[] for _ in range(side.count)] for side in sides]
    for frame in range(frames + 2):
        for which in range(max(side.count for side in sides)):
            for side, times in zip(sides, spent, strict=True):
                times[which % side.count].append(side.draw(which % side.count, frame))
    for side in sides:
        side.close()
    return [[float(np.median(times[2 * len(times) // (frames + 2) :])) for times in one] for one in spent]


def _before(code: Path, folder: Path) -> Iterator[tuple[str, str, Path]]:
    """Yield stages of the bare places: the current library, the name, and the file."""
    for where, (library, ground) in zip(NOW, BEFORE.items(), strict=True):
        spec, stage = folder / f"in_{library}.wms", folder / f"{library}.usda"
        spec.write_text(THINGS.format(library=library, called="", ground=ground, camera="front"), "utf-8")
        environment = {**os.environ, "PYTHONPATH": str(code)}
        subprocess.run([sys.executable, "-c", COMPILE, str(spec), str(stage)], cwd=code, env=environment, check=True)
        yield where, library, stage


def _now(folder: Path) -> Iterator[tuple[str, str, Path]]:
    """Yield stages of the furnished places: library, name, and file."""
    for where, places in NOW.items():
        text = THINGS.format(library=where, called=" as here", ground="here.ground", camera="here.front")
        left, drawn = dict(places), wmspec.load(text=text)
        for i in range(len(drawn)):
            stage = drawn[i].stage()
            names = " ".join(prim.GetName() for prim in stage.Traverse())
            for begin in [one for one in left if f"here_{one}_walls" in names or f"here_{one}_house" in names]:
                path = folder / f"{begin}.usda"
                stage.Flatten().Export(str(path))
                yield where, left.pop(begin), path


if __name__ == "__main__":
    main()
