"""How long `wmspec check` takes as a whole process, and how fast instances are built from their indices.

    python benchmarks/check.py

The bars are 0.3 s of processor time for each spec that comes with wmspec, and 20,000 instances a second. Both processor
and clock time are shown; either grows on a machine that does other things at the same time. The first run fills the
caches of the grammar and of Python's bytecode, which an installation has, and does not count. The exit code is 1 if a
bar is missed.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from wmspec.check.task import check
from wmspec.design.design import Design
from wmspec.parse.diagnostics import Report
from wmspec.parse.load import library_folder

MOST_SECONDS = 0.3
LEAST_RATE = 20_000
RUNS = 7
COMMAND = "from wmspec.cli import main; main()"


def check_seconds(path: Path, bytecode: str) -> tuple[float, float]:
    """Least processor and clock seconds of several whole runs. `bytecode` is a folder for Python's cache."""
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    environment["PYTHONPYCACHEPREFIX"] = bytecode
    processor, clock = [], []
    for _ in range(RUNS):
        before, began = _children(), time.perf_counter()
        command = [sys.executable, "-c", COMMAND, "check", str(path)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)
        processor.append(_children() - before)
        clock.append(time.perf_counter() - began)
    return min(processor), min(clock)


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def instances_per_second(path: Path) -> float:
    """How many instances of the task in a spec can be built from their indices in a second of processor time."""
    (spec,) = check(path, Report())
    design = Design(spec)
    began, count = time.process_time(), 0
    while time.process_time() - began < 1:
        for index in range(0, len(design), max(1, len(design) // 1000)):
            design[index]
            count += 1
    return count / (time.process_time() - began)


def main() -> None:
    """Measure every spec that comes with wmspec."""
    missed = False
    bytecode = tempfile.TemporaryDirectory()
    for path in sorted(library_folder().parent.rglob("*.wms")):
        if path.parent == library_folder():
            continue
        (processor, clock), rate = check_seconds(path, bytecode.name), instances_per_second(path)
        missed |= processor > MOST_SECONDS or rate < LEAST_RATE
        print(f"{path.stem:<20} check {processor:.2f} s ({clock:.2f} s by the clock)  {rate:9,.0f} instances/s")
    sys.exit(missed)


if __name__ == "__main__":
    main()
