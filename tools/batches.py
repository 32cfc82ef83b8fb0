"""Measure worlds of a batch in Newton and write their table of docs/benchmarks/newton.md.

python -m tools.batches SPEC [--worlds N]... [--seconds S] [--device DEVICE]

In an environment that has wmspec-newton, such as build/newton after `make newton`. Instances are the first ones of the
task that have the structure of its first.
"""

from __future__ import annotations

import re
from argparse import ArgumentParser
from collections.abc import Iterator, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from importlib.metadata import version
from itertools import islice
from pathlib import Path
from time import perf_counter, process_time

import numpy as np

import wmspec
from tools.reference import table
from wmspec.runtime.engines.registry import backend
from wmspec.sim.scene.model import Scene
from wmspec.sim.usd import read

PAGE = Path(__file__).parent.parent / "docs/benchmarks/newton.md"
SECTION = re.compile(r"(?<=<!-- worlds -->\n).*?(?=\n## |\Z)", re.DOTALL)
PACKAGES = ("newton", "mujoco", "mujoco-warp", "warp-lang")


def alike(spec: Path, seconds: float) -> Iterator[Scene]:
    """Yield the beginnings of the instances that have the structure of the first."""
    from wmspec_newton import batch

    first = ""
    for instance in wmspec.load(spec):
        scene = replace(read(instance.stage()), duration=seconds)
        made = batch.structure(*batch.prepare(scene))
        first = first or made
        if made == first:
            yield scene


def measured(scenes: Sequence[Scene], counts: Sequence[int], device: str | None) -> Iterator[tuple[str, ...]]:
    """Yield a row for the scenes one by one, and one for each number of worlds."""
    from wmspec_newton import execute_all

    for _ in range(2):  # kernels are compiled in the first run
        begun, here = process_time(), perf_counter()
        alone = [backend("newton").execute(scene) for scene in scenes[: max(counts)]]
        spent, passed = process_time() - begun, perf_counter() - here
    yield "one by one, MuJoCo", f"{spent / len(alone):.1f} s", f"{passed / len(alone):.1f} s", ""
    for count in counts:
        some = scenes[:count]
        execute_all([replace(scene, duration=0.01) for scene in some], device)
        begun, here = process_time(), perf_counter()
        together = execute_all(some, device)
        spent, passed = process_time() - begun, perf_counter() - here
        gap = max(float(np.abs(a.position - b.position).max()) for a, b in zip(alone, together, strict=False))
        yield f"{count}", f"{spent / count:.1f} s", f"{passed / count:.1f} s", f"{gap * 1000:.2f} mm"


def main() -> None:
    """Rewrite the section."""
    parser = ArgumentParser(description="Measure worlds of a batch.")
    parser.add_argument("spec", type=Path)
    parser.add_argument("--worlds", type=int, nargs="+", default=[1, 4, 16])
    parser.add_argument("--seconds", type=float, default=0.25, help="of each episode")
    parser.add_argument("--device", help="of Warp, such as cuda:0")
    given = parser.parse_args()
    scenes = list(islice(alike(given.spec, given.seconds), max(given.worlds)))
    versions = ", ".join(f"{name} {version(name)}" for name in PACKAGES)
    where = given.device or "the default device"
    distance = "largest distance from execution one by one"
    heads = ("worlds in a batch", "processor time per instance", "elapsed time per instance", distance)
    rows = list(measured(scenes, given.worlds, given.device))
    when = datetime.now(UTC).date()
    lines = [
        f"\nThe first {given.seconds:g} s of instances of `{given.spec.stem}`, on {where}, {when}, {versions}:\n",
        *table(heads, rows),
    ]
    text = PAGE.read_text(encoding="utf-8")
    PAGE.write_text(SECTION.sub(lambda _: "\n".join(lines), text, count=1), encoding="utf-8")


if __name__ == "__main__":
    main()
