"""How long `wmspec check` takes as a whole process, and how fast instances are built from their indices.

    python -m benchmarks.check [SPECS]

The bars are 0.3 s of processor time for each spec that comes with wmspec, the median of five runs, and 20,000
instances a second. A machine that does other things at the same time is slower at this too, so what Python alone takes
to start is shown beside it. The first run fills the caches of the grammar and of Python's bytecode, which an
installation has, and does not count. The exit code is 1 if a bar is missed.

For comparison: Scenic, which draws scenes until one is allowed, was measured at about 350 scenes a second.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

from wmspec.check.task import check
from wmspec.design.design import Design
from wmspec.parse.diagnostics import Report
from wmspec.parse.load import library_folder

MOST_SECONDS = 0.3
LEAST_RATE = 20_000
RUNS = 5
CHECK = "from wmspec.cli import main; main()"


def seconds(code: str, *arguments: str, bytecode: str) -> tuple[float, float]:
    """Median processor and clock seconds of whole runs of Python. `bytecode` is a folder for Python's cache."""
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    environment["PYTHONPYCACHEPREFIX"] = bytecode
    processor, clock = [], []
    for run in range(RUNS + 1):
        before, began = _children(), time.perf_counter()
        command = [sys.executable, "-c", code, *arguments]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)
        if run:
            processor.append(_children() - before)
            clock.append(time.perf_counter() - began)
    return median(processor), median(clock)


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


def specs() -> list[Path]:
    """The specs named on the command line, or all that come with wmspec."""
    named = [Path(argument) for argument in sys.argv[1:]]
    return named or [p for p in sorted(library_folder().parent.rglob("*.wms")) if p.parent != library_folder()]


def main() -> None:
    """Measure."""
    missed = False
    with tempfile.TemporaryDirectory() as bytecode:
        for path in specs():
            start, _ = seconds("import wmspec", bytecode=bytecode)
            processor, clock = seconds(CHECK, "check", str(path), bytecode=bytecode)
            rate = instances_per_second(path)
            missed |= processor > MOST_SECONDS or rate < LEAST_RATE
            times = f"{processor:.3f} s ({clock:.2f} s by the clock), {processor / start:3.0f} times `import wmspec`"
            print(f"{path.parent.name + '/' + path.stem:<30} check {times}; {rate:9,.0f} instances/s", flush=True)
    sys.exit(missed)


if __name__ == "__main__":
    main()
