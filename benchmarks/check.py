"""Processor time of `wmspec check`, relative to the import of numpy.

    python -m benchmarks.check [SPECS]

For each spec (by default those of WM-ABench): a process with an empty cache, with cached libraries (the spec changed),
and with a cached result; and a re-check in the language server after an edit, without and with scenes. Then fifty specs
in one call, and the instances built per second. Medians of five runs (one uncached run for fifty specs). The first run
of a process fills Python's bytecode cache and does not count. Exit code 1 if a limit is exceeded.
"""

from __future__ import annotations

import gc
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from itertools import cycle, islice
from pathlib import Path
from statistics import median

from wmspec.api.loading import TextCheck
from wmspec.compile.design.design import Design
from wmspec.core.diagnostics import Report
from wmspec.lang.check.statements.task import check
from wmspec.lang.parse.files import catalogue_folders, read_source, spec_files

#: Limits: a process with a cached result; its multiple of the numpy import; fifty specs; a re-check.
MOST_SECONDS, MOST_TIMES, MOST_FIFTY, MOST_RECHECK = 0.3, 2.0, 3.0, 0.1
LEAST_RATE = 20_000
RUNS = 5
#: Measured scenes per second of Scenic, which uses rejection sampling.
SCENIC = 350


class Processes:
    """Runs Python with its own bytecode cache and wmspec cache."""

    def __init__(self, folder: Path) -> None:
        self._cache = folder / "cache"
        self._environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
        self._environment |= {"PYTHONPYCACHEPREFIX": str(folder / "bytecode"), "WMSPEC_CACHE_DIR": str(self._cache)}

    def seconds(self, *command: str, before: Callable[[], None] = lambda: None, runs: int = RUNS) -> float:
        """Return the median time of several runs; `before` is called before each."""
        taken = []
        for _ in range(runs + 1):
            before()
            began = _children()
            subprocess.run([sys.executable, *command], check=True, capture_output=True, env=self._environment)
            taken.append(_children() - began)
        return median(taken[1:])

    def check(self, *paths: Path, before: Callable[[], None] = lambda: None, runs: int = RUNS) -> float:
        """Return the median time of `wmspec check`."""
        return self.seconds("-m", "wmspec", "check", *map(str, paths), before=before, runs=runs)

    def forget(self) -> None:
        """Empty the cache of wmspec."""
        shutil.rmtree(self._cache, ignore_errors=True)

    def forget_results(self) -> None:
        """Empty the cache except for libraries."""
        for entry in self._cache.glob("check-*"):
            entry.unlink()


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def rechecks(path: Path) -> tuple[float, float]:
    """Return the time of a re-check after an edit, without and with scenes."""
    text, own, all_of_it = read_source(path).text, [], []
    for edit in range(RUNS + 1):
        began = time.process_time()
        edited = TextCheck(f"{text}\n# {edit}\n", path)
        edited.diagnosis(tried=False)
        own.append(time.process_time() - began)
        edited.diagnosis(tried=True)
        all_of_it.append(time.process_time() - began)
    return median(own[1:]), median(all_of_it[1:])


def instances_per_second(path: Path) -> float:
    """Return the instances of a spec's task that are built per second of processor time."""
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
    """Return the specs of the command line, or those of WM-ABench."""
    named = spec_files(map(Path, sys.argv[1:]))
    return named or spec_files(catalogue_folders())


def rows(processes: Processes, paths: list[Path]) -> Iterator[tuple[float, ...]]:
    """Print and yield the figures of each spec."""
    print(f"{'':<34} {'empty':>8} {'changed':>8} {'cached':>8} {'text':>8} {'scenes':>8} {'instances/s':>12}")
    for path in paths:
        empty = processes.check(path, before=processes.forget)
        changed = processes.check(path, before=processes.forget_results)
        figures = (empty, changed, processes.check(path), *rechecks(path), instances_per_second(path))
        print(line(f"{path.parent.name}/{path.stem}", figures), flush=True)
        yield figures


def line(name: str, figures: tuple[float, ...]) -> str:
    """Return a line of the table."""
    *seconds, rate = figures
    return f"{name:<34} " + " ".join(f"{each:8.3f}" for each in seconds) + f" {rate:12,.0f}"


def fifty(folder: Path, paths: list[Path]) -> list[Path]:
    """Return fifty different files: copies of the specs."""
    copies = []
    for number, path in enumerate(islice(cycle(paths), 50)):
        copies.append(folder / f"{path.stem}_{number}.wms")
        shutil.copy(path, copies[-1])
    return copies


def main() -> None:
    """Measure, and print a table."""
    paths = specs()
    gc.set_threshold(100_000, 20, 100)  # as the language server does
    with tempfile.TemporaryDirectory() as name:
        processes = Processes(Path(name))
        numpy = processes.seconds("-c", "import numpy")
        print(f"{'Python alone':<34} {processes.seconds('-c', 'pass'):8.3f}")
        print(f"{'import numpy':<34} {numpy:8.3f}")
        found = list(rows(processes, paths))
        many = fifty(Path(name), paths)
        in_one_call = [processes.check(*many, before=f, runs=1) for f in (processes.forget, processes.forget_results)]
        cached = processes.check(*many)
    columns = list(zip(*found, strict=True))
    print(line(f"the median of {len(found)} specs", tuple(map(median, columns))))
    print(line("the worst", (*map(max, columns[:-1]), min(columns[-1]))))
    print(f"{'fifty specs in one call':<34} " + " ".join(f"{each:8.3f}" for each in (*in_one_call, cached)))
    print(f"{'Scenic, scenes/s':<34} {'':>44} {SCENIC:12}")
    slowest = max(columns[2])
    missed = {
        f"a cached check takes {slowest:.2f} s": slowest > min(MOST_SECONDS, MOST_TIMES * numpy),
        f"fifty cached specs take {cached:.2f} s": cached > MOST_FIFTY,
        f"a re-check of a text takes {max(columns[3]):.2f} s": max(columns[3]) > MOST_RECHECK,
        f"only {min(columns[-1]):,.0f} instances a second": min(columns[-1]) < LEAST_RATE,
    }
    for what, true in missed.items():
        if true:
            print(f"missed: {what}")
    sys.exit(any(missed.values()))


if __name__ == "__main__":
    main()
