"""How long `wmspec check` takes as a whole process, and how fast instances are built from their indices.

    python -m benchmarks.check [SPECS]

The bars are 0.3 s of processor time for each spec that comes with wmspec, and 20,000 instances a second. Of seven runs
the quickest counts, since what else a machine does can only slow it; what Python alone takes to start is shown too. The
first run fills the caches of the grammar and of Python's bytecode, which an installation has, and does not count. The
exit code is 1 if a bar is missed.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from wmspec.api.loading import spec_files
from wmspec.compile.design.design import Design
from wmspec.core.diagnostics import Report
from wmspec.lang.check.statements.task import check
from wmspec.lang.parse.load import catalogue_folders

MOST_SECONDS = 0.3
LEAST_RATE = 20_000
RUNS = 7
#: Scenes a second that Scenic was measured at. It draws scenes until one is allowed.
SCENIC = 350


@dataclass(frozen=True)
class Seconds:
    """What a process took: of the processor and by the clock."""

    processor: float
    clock: float


@dataclass(frozen=True)
class Measured:
    """A spec's name, what checking it takes, and its instances a second."""

    name: str
    check: Seconds
    rate: float


def seconds(*command: str, bytecode: str) -> Seconds:
    """The least that a run of Python takes. `bytecode` is a folder for Python's cache."""
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    environment["PYTHONPYCACHEPREFIX"] = bytecode
    taken = list(_runs([sys.executable, *command], environment))[1:]
    return Seconds(min(t.processor for t in taken), min(t.clock for t in taken))


def _runs(command: list[str], environment: dict[str, str]) -> Iterator[Seconds]:
    for _ in range(RUNS + 1):
        before, began = _children(), time.perf_counter()
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)
        yield Seconds(_children() - before, time.perf_counter() - began)


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def instances_per_second(path: Path) -> float:
    """How many instances of the task in a spec can be built from their indices in a second of processor time."""
    spec, *_ = check(path, Report())  # one of its variants
    design = Design(spec)
    return max(_rate(design) for _ in range(RUNS))


def _rate(design: Design) -> float:
    began, count = time.process_time(), 0
    while time.process_time() - began < 1 / RUNS:
        for index in range(0, len(design), max(1, len(design) // 1000)):
            design[index]
            count += 1
    return count / (time.process_time() - began)


def specs() -> list[Path]:
    """The specs named on the command line, those of folders too, or all that rebuild the paper."""
    named = spec_files(map(Path, sys.argv[1:]))
    return named or spec_files(catalogue_folders())


def measured(bytecode: str) -> Iterator[Measured]:
    """Each spec in turn."""
    for path in specs():
        taken = seconds("-m", "wmspec", "check", str(path), bytecode=bytecode)
        yield Measured(f"{path.parent.name}/{path.stem}", taken, instances_per_second(path))


def line(name: str, taken: Seconds, rate: str = "") -> str:
    """A line of the table."""
    return f"{name:<34} {taken.processor:9.3f} {taken.clock:9.3f} {rate:>12}"


def main() -> None:
    """Measure, and print a table."""
    print(f"{'':<34} {'processor':>9} {'clock':>9} {'instances/s':>12}")
    found: list[Measured] = []
    with tempfile.TemporaryDirectory() as bytecode:
        print(line("Python alone", seconds("-c", "pass", bytecode=bytecode)))
        for spec in measured(bytecode):
            print(line(spec.name, spec.check, f"{spec.rate:,.0f}"), flush=True)
            found.append(spec)
    slowest, rates = max(found, key=lambda s: s.check.processor), [s.rate for s in found]
    middle = Seconds(median(s.check.processor for s in found), median(s.check.clock for s in found))
    print(line(f"the median of {len(found)} specs", middle, f"{median(rates):,.0f}"))
    print(line("the worst", slowest.check, f"{min(rates):,.0f}") + f"  (check: {slowest.name})")
    print(f"{'Scenic, scenes/s':<34} {'':>9} {'':>9} {SCENIC:>12}")
    sys.exit(slowest.check.processor > MOST_SECONDS or min(rates) < LEAST_RATE)


if __name__ == "__main__":
    main()
