"""Random specs, many of them: none may end in a traceback, take more than 2 s or more than 512 MB.

    python benchmarks/fuzz.py --count 100000 --workers 2

An input is a pure function of its number. Each is checked, tried out and, if it can be parsed, formatted twice. What
fails is written to `--output`, and the exit code is 1.
"""

from __future__ import annotations

import argparse
import os
import random
import resource
import signal
import sys
import time
import traceback
from collections.abc import Iterator
from multiprocessing import get_context
from pathlib import Path
from types import FrameType

from wmspec.check.task import check_program
from wmspec.errors import WmsError
from wmspec.parse.diagnostics import Report, SpecError
from wmspec.parse.format import format_spec
from wmspec.parse.load import library_folder, load_source
from wmspec.parse.source import Source
from wmspec.stage.trial import trial

#: Processor seconds that an input may take.
MOST_SECONDS = 2.0
#: Bytes of memory that the process may come to hold.
MOST_MEMORY = 512 * 2**20
CORPUS = Path(__file__).parent.parent / "tests/corpus"
TEXTS = [p.read_text() for p in [*sorted(library_folder().parent.rglob("*.wms")), *sorted(CORPUS.glob("*.wms"))]]
WORDS = sorted({word for text in TEXTS for word in text.split()})
ODD = [
    "{",
    "}",
    "(",
    ")",
    "[",
    "]",
    '"',
    '"""',
    "..",
    "at",
    ":",
    ",",
    "-",
    "*",
    "\x00",
    "é",
    "\U0001f600",
    "#",
    "1e999",
    "1e-999",
]
ODD += [
    "9" * 400,
    "if",
    "then",
    "else",
    "with",
    "after",
    "\r",
    "\t",
    "0 .. 1e9 by 1e-9",
    "m^99",
    "(" * 300,
    "-" * 300,
    "not " * 99,
]


class TooSlow(BaseException):
    """The time is up; a BaseException, so that nothing takes it for a mistake of the user."""


def text_of(number: int) -> str:
    """Input `number`: a spec with words swapped, cut, doubled, or characters changed; or random words."""
    rng = random.Random(number)  # noqa: S311
    if rng.random() < 0.1:
        return " ".join(rng.choice(WORDS if rng.random() < 0.8 else ODD) for _ in range(rng.randint(0, 60)))
    text = rng.choice(TEXTS)
    for _ in range(rng.choice([1, 1, 2, 3, 5, 9])):
        text = _mutated(text, rng)
    return text


def _mutated(text: str, rng: random.Random) -> str:
    i = rng.randint(0, len(text))
    j = min(len(text), i + rng.choice([0, 1, 3, 10, 40]))
    match rng.randint(0, 5):
        case 0:
            return text[:i] + rng.choice(ODD) + text[j:]
        case 1:
            return text[:i] + text[j:]
        case 2:
            return text[:j] + text[i:j] * rng.choice([1, 2, 20]) + text[j:]
        case 3:
            return text[:i] + chr(rng.choice([rng.randint(0, 127), rng.randint(0, 0xD7FF)])) + text[i:]
        case 4:
            words = text.split(" ")
            words[rng.randrange(len(words))] = rng.choice(WORDS)
            return " ".join(words)
        case _:
            lines = text.split("\n")
            k = rng.randrange(len(lines))
            lines.insert(rng.randint(0, len(lines)), lines[k] if rng.random() < 0.5 else lines.pop(k))
            return "\n".join(lines)


def survive(text: str) -> None:
    """Check, try out and format a text; raises whatever is a defect of ours."""
    source = Source("fuzz.wms", text)
    report = Report()
    try:
        for spec in check_program(load_source(source, Path(), report), report):
            trial(spec, report)
    except WmsError:
        pass
    for diagnostic in report.diagnostics:
        assert diagnostic.render()
        assert diagnostic.record()
    try:
        once = format_spec(source)
    except SpecError:
        return
    assert format_spec(Source("fuzz.wms", once)) == once, "formatting twice is not formatting once"


def attempt(number: int) -> tuple[int, float, str]:
    """The number, its processor seconds, and what went wrong, if anything."""
    began = time.process_time()
    signal.setitimer(signal.ITIMER_PROF, MOST_SECONDS)
    try:
        survive(text_of(number))
        failure = ""
    except TooSlow:
        failure = f"took more than {MOST_SECONDS} s"
    except BaseException:  # noqa: BLE001  a crash of any sort is what we look for
        failure = traceback.format_exc()
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    if memory > MOST_MEMORY and not failure:
        failure = f"the process holds {memory / 2**20:.0f} MB"
    return number, time.process_time() - began, failure


def _stop(_signal: int, _frame: FrameType | None) -> None:
    raise TooSlow


def _start() -> None:
    signal.signal(signal.SIGPROF, _stop)
    resource.setrlimit(resource.RLIMIT_AS, (4 * MOST_MEMORY, 4 * MOST_MEMORY))


def run(numbers: range, workers: int) -> Iterator[tuple[int, float, str]]:
    """The results of all inputs, in any order. Workers are renewed, so that memory is that of few inputs."""
    with get_context("spawn").Pool(workers, _start, maxtasksperchild=40) as pool:
        yield from pool.imap_unordered(attempt, numbers, chunksize=50)


def main() -> None:
    """Run and report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--output", type=Path, default=Path("out/fuzz"))
    options = parser.parse_args()
    done = failed = 0
    slowest = (0.0, 0)
    for number, seconds, failure in run(range(options.first, options.first + options.count), options.workers):
        done += 1
        slowest = max(slowest, (seconds, number))
        if failure:
            failed += 1
            options.output.mkdir(parents=True, exist_ok=True)
            (options.output / f"{number}.wms").write_text(text_of(number), encoding="utf-8")
            (options.output / f"{number}.txt").write_text(failure, encoding="utf-8")
            print(f"{number}: {failure.strip().splitlines()[-1]}", flush=True)
        if done % 5000 == 0:
            print(f"{done:,} inputs, {failed} failed, slowest {slowest[0]:.2f} s (input {slowest[1]})", flush=True)
    print(f"{done:,} inputs, {failed} failed, slowest {slowest[0]:.2f} s (input {slowest[1]})")
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()
