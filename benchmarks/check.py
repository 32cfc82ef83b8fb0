"""How long `wmspec check` takes as a whole process, and how fast instances are built from their indices.

    python benchmarks/check.py

The bars are 0.3 s of processor time for each spec that comes with wmspec, and 20,000 instances a second. Both processor
and clock time are shown; either grows on a machine that does other things at the same time. The first run fills the
grammar's cache and does not count. The exit code is 1 if a bar is missed.
"""

from __future__ import annotations

import resource
import subprocess
import sys
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


def check_seconds(path: Path) -> tuple[float, float]:
    """Least processor and clock seconds of several whole runs."""
    processor, clock = [], []
    for _ in range(RUNS):
        before, began = _children(), time.perf_counter()
        subprocess.run([sys.executable, "-c", COMMAND, "check", path], check=True, stdout=subprocess.DEVNULL)
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
    for path in sorted(library_folder().parent.rglob("*.wms")):
        if path.parent == library_folder():
            continue
        (processor, clock), rate = check_seconds(path), instances_per_second(path)
        missed |= processor > MOST_SECONDS or rate < LEAST_RATE
        print(f"{path.stem:<20} check {processor:.2f} s ({clock:.2f} s by the clock)  {rate:9,.0f} instances/s")
    sys.exit(missed)


if __name__ == "__main__":
    main()
