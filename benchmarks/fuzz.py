"""Fuzz the checker and readers: no input may cause a traceback, or take much time or memory.

    python -m benchmarks.fuzz --count 100000 --workers 2
    python -m benchmarks.fuzz --of files --count 20000 --workers 2
    python -m benchmarks.fuzz --of changed --count 20000 --workers 2

A spec may take 5 s and 512 MB, a file 10 s and 1 GB (`benchmarks/damaged.py`: damaged, or whole and changed), and
nothing may be written outside the output folder. An input is a pure function of its number and of the texts in the
repository. A spec is checked, dry-run and, if it parses, formatted twice. Failures are written to `--output`; the exit
code is then 1.
"""

from __future__ import annotations

import argparse
import os
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from types import FrameType

from benchmarks.inputs import ROOT, text_of
from wmspec.compile.lint.dry_run import dry_run
from wmspec.core.diagnostics import Report, SpecError, WmsError
from wmspec.core.places import Source
from wmspec.lang.check.statements.task import check_program
from wmspec.lang.parse.format import format_spec
from wmspec.lang.parse.load import load_source
from wmspec.runtime.workers.pool import JobFailure, PoolConfig, map_ordered

#: Time limit of an input, in processor seconds: a slow machine needs 2 s for the longest file of the catalogue.
MOST_SECONDS = 5.0
#: Memory limit of the process, in bytes.
MOST_MEMORY = 512 * 2**20


class TooSlow(BaseException):
    """The time limit is exceeded; a BaseException, so that no handler catches it."""


@cache
def folder() -> Path:
    """Return the folder of the inputs, with meshes, a picture and assets."""
    import trimesh
    from PIL import Image

    made = Path(tempfile.mkdtemp(prefix="fuzz"))
    shutil.copytree(ROOT / "tests/corpus/assets", made / "assets")
    shutil.copy(ROOT / "docs/cabinet.urdf", made)
    trimesh.creation.cylinder(3, 8, sections=16).export(made / "cup.obj")
    trimesh.creation.box((4, 2, 3)).export(made / "wedge.stl")
    Image.new("RGB", (8, 8), "red").save(made / "label.png")
    return made


def survive(source: Source) -> str:
    """Check a text and try it out; returns how far it came. Raises whatever is a defect of ours."""
    report = Report()
    came = "unread"
    try:
        program = load_source(source, folder(), report)
        came = "unread" if report.failed else "read"
        for spec in check_program(program, report):
            dry_run(spec, report)
            came = "tried"
    except WmsError:
        pass
    for diagnostic in report.diagnostics:
        assert diagnostic.render()
        assert diagnostic.record()
    return came


def survive_formatting(source: Source) -> None:
    """Format a text, if it can be read. Raises whatever is a defect of ours."""
    try:
        once = format_spec(source)
    except SpecError:
        return
    assert format_spec(Source("fuzz.wms", once)) == once, "formatting twice is not formatting once"


@dataclass(frozen=True)
class Outcome:
    """The result of an input: how far it came, its failure, and the memory of the process.

    The seconds are processor time of checking or formatting, the larger one.
    """

    number: int
    text: str
    came: str
    seconds: float
    memory: int
    failure: str


def attempt(number: int) -> Outcome:
    """Make an input and try it."""
    text, came, failure, seconds = text_of(number), "failed", "", 0.0
    source = Source(str(folder() / "fuzz.wms"), text)
    for survived in (survive, survive_formatting):
        began = time.process_time()
        signal.setitimer(signal.ITIMER_PROF, MOST_SECONDS)
        try:
            came = survived(source) or came
        except TooSlow:
            failure = f"took more than {MOST_SECONDS} s\n{traceback.format_exc()}"
        except BaseException:  # noqa: BLE001  a crash of any sort is what we look for
            failure = traceback.format_exc()
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
        seconds = max(seconds, time.process_time() - began)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    if memory > MOST_MEMORY and not failure:
        failure = f"the process holds {memory / 2**20:.0f} MB"
    return Outcome(number, text, came, seconds, memory, failure)


def _stop(_signal: int, _frame: FrameType | None) -> None:
    raise TooSlow


def _start() -> None:
    signal.signal(signal.SIGPROF, _stop)
    folder()
    resource.setrlimit(resource.RLIMIT_AS, (4 * MOST_MEMORY, 4 * MOST_MEMORY))


def run(numbers: range, workers: int) -> Iterator[Outcome]:
    """Yield the outcomes of all inputs, in any order. Workers are renewed, so that memory is that of few inputs."""
    with get_context("spawn").Pool(workers, _start, maxtasksperchild=40) as pool:
        yield from pool.imap_unordered(attempt, numbers, chunksize=50)


class Tally:
    """Statistics of outcomes."""

    def __init__(self) -> None:
        self.came = Counter[str]()
        self.slowest = self.seconds = 0.0
        self.memory = self.failed = 0

    def add(self, outcome: Outcome) -> None:
        """Add an outcome."""
        self.came[outcome.came] += 1
        self.slowest, self.seconds = max(self.slowest, outcome.seconds), self.seconds + outcome.seconds
        self.memory, self.failed = max(self.memory, outcome.memory), self.failed + bool(outcome.failure)

    def __str__(self) -> str:
        count = self.came.total()
        tried = self.came["tried"]
        read = tried + sum(n for came, n in self.came.items() if came.split()[-1] == "read")
        return (
            f"{count:,} inputs, {read:,} of them read and {tried:,} staged: {self.failed} failed; "
            f"slowest {self.slowest:.2f} s, mean {self.seconds / count:.3f} s, most memory {self.memory >> 20} MB"
        )


# ---------------------------------------------------------------- files

#: Limits of a damaged file: processor seconds and bytes of memory.
FILE_SECONDS, FILE_MEMORY = 10.0, 2**30
#: Files per batch of a worker.
TOGETHER = 20


def attempt_files(kind: str, first: int, last: int) -> list[Outcome]:
    """Damage or change the files of these numbers, and read them."""
    return [_attempt_file(kind, number) for number in range(first, last)]


def _attempt_file(kind: str, number: int) -> Outcome:
    from benchmarks.damaged import attempt_changed, attempt_file

    came, failure, began = "failed", "", time.process_time()
    try:
        came = {"files": attempt_file, "changed": attempt_changed}[kind](number)
    except BaseException:  # noqa: BLE001  a crash of any sort is what we look for
        failure = traceback.format_exc()
    seconds, memory = time.process_time() - began, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    if not failure and (seconds > FILE_SECONDS or memory > FILE_MEMORY):
        failure = f"it took {seconds:.1f} s, and the process holds {memory / 2**20:.0f} MB"
    return Outcome(number, "", came, seconds, memory, failure)


def run_files(kind: str, numbers: range, workers: int) -> Iterator[Outcome]:
    """Yield the outcomes of all files, in order; a crash or hang of a worker is a failure of its files."""
    pieces = [(kind, first, min(first + TOGETHER, numbers.stop)) for first in numbers[::TOGETHER]]
    for (_, first, last), outcomes in zip(
        pieces, map_ordered(attempt_files, pieces, PoolConfig(workers, 300)), strict=True
    ):
        if isinstance(outcomes, JobFailure):
            yield from (Outcome(n, "", "failed", 0.0, 0, f"{outcomes.reason}: {first} to {last}") for n in (first,))
        else:
            yield from outcomes


def keep(outcome: Outcome, output: Path) -> None:
    """Write and print a failure."""
    output.mkdir(parents=True, exist_ok=True)
    (output / f"{outcome.number}.wms").write_text(outcome.text, encoding="utf-8", errors="replace")
    (output / f"{outcome.number}.txt").write_text(outcome.failure, encoding="utf-8", errors="replace")
    print(f"{outcome.number}: {outcome.failure.strip().splitlines()[-1]}", flush=True)


def main() -> None:
    """Run and report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--of", choices=("specs", "files", "changed"), default="specs")
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--output", type=Path, default=Path("out/fuzz"))
    options = parser.parse_args()
    tally = Tally()
    numbers = range(options.first, options.first + options.count)
    files = options.of != "specs"
    for outcome in run_files(options.of, numbers, options.workers) if files else run(numbers, options.workers):
        tally.add(outcome)
        if outcome.failure:
            keep(outcome, options.output)
        if tally.came.total() % 1000 == 0:
            print(tally, flush=True)
    print(tally)
    if files:
        print(*(f"{count:,} {came}" for came, count in sorted(tally.came.items())), sep="; ")
    sys.exit(tally.failed > 0)


if __name__ == "__main__":
    from benchmarks.fuzz import main as run_main  # workers find its functions under this name

    run_main()
