"""Does what ran with an earlier version run the same? Stages in every engine, by that version's code and by this.

python -m tools.before compile CHECKOUT FOLDER [--of now]   stages of the checkout's specs, made by it; or of today's
python -m tools.before run CHECKOUT FOLDER                  every stage, by the code of the checkout and by this one
python -m tools.before compare CHECKOUT FOLDER              what differs; docs/anyone.md tells it

What was run is not run again. A checkout is one of commit 69255fb or later.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
HERE = Path(__file__).resolve().parents[1]
ENGINES = ("mujoco", "pybullet", "sapien")
SIDES = ("before", "now")

#: By either code: so many instances of each task, evenly through its design.
COMPILE = """
import sys
from pathlib import Path
try:
    from wmspec.cli.common import one_task
    from wmspec.compile.design.design import Design
    from wmspec.compile.stage.episode import document
    from wmspec.compile.stage.layers import compose

    def tasks(path):
        task = one_task(path)
        design = Design(task, 0)
        return [(task.name, len(design), lambda i: compose(document(task, design[i])))]
except ImportError:
    import wmspec

    def tasks(path):
        return [(task.name, len(task), lambda i, task=task: task[i].stage()) for task in wmspec.load_all(path)]

out, count = Path(sys.argv[1]), int(sys.argv[2])
for path in map(Path, sys.argv[3:]):
    try:
        for name, size, stage in tasks(path):
            for i in sorted({size * k // count for k in range(count)}):
                stage(i).Flatten().Export(str(out / f"{name}_{i}.usda"))
    except Exception as error:
        print(f"{path}: {type(error).__name__}: {error}", flush=True)
"""
#: By either code: a trace of each stage in each engine, or why there is none.
RUN = """
import sys
from pathlib import Path
import numpy as np
from pxr import Usd
from wmspec.runtime.engines.registry import backend
try:
    import wmspec.sim.usd.schema
    from wmspec.sim.usd import read
except ImportError:
    import wmspec.sim.scene.schema
    from wmspec.sim.scene.read import read

out, engines = Path(sys.argv[1]), sys.argv[2].split(",")
for path in map(Path, sys.argv[3:]):
    for engine in engines:
        kept = out / f"{path.stem}.{engine}.npz"
        if kept.exists():
            continue
        try:
            trace = backend(engine).execute(read(Usd.Stage.Open(str(path))))
            made = {"bodies": list(trace.bodies), "position": trace.position, "orientation": trace.orientation}
        except Exception as error:
            made = {"refusal": f"{type(error).__name__}: {error}"}
        np.savez_compressed(kept, **made)
"""


def compiled(code: Path, folder: Path, count: int) -> None:
    """Make the stages of its specs."""
    (folder / "stages").mkdir(parents=True, exist_ok=True)
    specs = sorted(path for path in (code / "specs").rglob("*.wms") if path.parent.name != "library")
    _by(code, COMPILE, folder / "stages", count, *specs)


def executed(checkout: Path, folder: Path) -> None:
    """Run the stages by the code of the checkout, and by this one."""
    for side, code in zip(SIDES, (checkout, HERE), strict=True):
        (folder / side).mkdir(exist_ok=True)
        _by(code, RUN, folder / side, ",".join(ENGINES), *sorted((folder / "stages").glob("*.usda")))


def _by(code: Path, script: str, *arguments: object) -> None:
    environment = {**os.environ, "PYTHONPATH": str(code)}
    subprocess.run([sys.executable, "-c", script, *map(str, arguments)], cwd=code, env=environment, check=True)


def differences(folder: Path) -> Iterator[tuple[str, str]]:
    """Of every run, its name and what became of it, in words."""
    for before in sorted((folder / SIDES[0]).glob("*.npz")):
        now = folder / SIDES[1] / before.name
        with np.load(before) as one, np.load(now) as other:
            yield before.stem, _difference(dict(one), dict(other))


def _difference(one: dict[str, Array], other: dict[str, Array]) -> str:
    if "refusal" in one or "refusal" in other:
        then, now = (str(side.get("refusal", "")) for side in (one, other))
        return "refused by both" if then and now else f"refused now: {now}" if now else f"runs now: {then}"
    here = [list(other["bodies"]).index(name) for name in one["bodies"]]
    p, q, r, s = one["position"], one["orientation"], other["position"][:, here], other["orientation"][:, here]
    if p.shape != r.shape:
        return "lasts another time"
    if np.array_equal(p, r) and np.array_equal(q, s):
        return "the same"
    apart = 1e3 * np.linalg.norm(p - r, axis=2)
    turned = 2 * np.degrees(np.arccos(np.clip(np.abs((q * s).sum(axis=2)), 0, 1)))
    name = one["bodies"][apart.max(axis=0).argmax()]
    return f"apart by {apart.max():.3g} mm, {apart[-1].max():.3g} at the end, and {turned.max():.3g} degrees: {name}"


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("compile", "run", "compare"))
    parser.add_argument("checkout", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--count", type=int, default=4, help="instances of a task")
    parser.add_argument("--of", choices=SIDES, default=SIDES[0], help="whose specs")
    given = parser.parse_args()
    checkout, folder = given.checkout.resolve(), given.folder.resolve()
    if given.what == "compile":
        compiled(checkout if given.of == SIDES[0] else HERE, folder, given.count)
    elif given.what == "run":
        executed(checkout, folder)
    else:
        for name, what in differences(folder):
            print(f"{name}: {what}")


if __name__ == "__main__":
    main()
