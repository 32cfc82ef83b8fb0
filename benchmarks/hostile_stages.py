"""Hostile USD stages that compose: none may hang, fill the memory, crash, write outside, or show a traceback.

    python -m benchmarks.hostile_stages --count 1000

A stage is a scene of several files (`benchmarks/composed_stages.py`) with up to three twists (`stage_twists.py`). It is
opened, read, executed in MuJoCo for 0.05 s, saved and loaded again, in a separate process.
"""

from __future__ import annotations

import argparse
import os
import random
import resource
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

from benchmarks.composed_stages import ARCS, Plan, body, crate, package, usda
from benchmarks.stage_twists import TWISTS
from wmspec.api.episode import load_episode, run
from wmspec.core.diagnostics import WmsError
from wmspec.runtime.workers.pool import HelperProcess, JobFailure

#: Limits of a stage: seconds, and bytes of resident memory.
SECONDS, BYTES = 120.0, 2**31
#: Stages that one process tries, so that its memory is that of few stages.
TOGETHER = 50
#: Text of a file outside of a stage's folder, which may appear nowhere.
SECRET = "d41f2b secret"  # noqa: S105


class Outcome(NamedTuple):
    """What happened to a stage: executed, refused, or the failure."""

    number: int
    twists: tuple[str, ...]
    kind: str
    words: str
    seconds: float
    memory: int


def plan(number: int, folder: Path) -> Plan:
    """Plan a scene and its twists, a pure function of its number; about a sixth of the scenes have no twist."""
    chance = random.Random(number)  # noqa: S311
    made = Plan(chance, folder)
    os.mkfifo(folder / "pipe.usda")
    (folder / "folder.usda").mkdir()
    made.layers |= {"empty.usda": "", "words.txt": "no layer", "lights.usda": usda('def DistantLight "Sun" { }')}
    for place in range(chance.randrange(1, 5)):
        chance.choice(ARCS)(made, f"body{place}", f"{place - 2}, {chance.choice((0, 1))}, 1")
    package(made, "packed.usdz", {"inner.usda": usda(body(made, "ball"), 'defaultPrim = "ball"')})
    crate(made, usda(body(made, "ball")), "damaged.usdc", chance.choice((1, 4, 30)))
    for _ in range(chance.choice((0, 1, 1, 1, 2, 3))):
        twist = chance.choice(TWISTS)
        made.twists.append(twist.__name__)
        twist(made)
    return made


def attempt(number: int, root: str) -> Outcome:
    """Make a stage, execute and save it. Exceptions other than WmsError are failures."""
    begin = perf_counter()
    home = secrets(Path(root))
    made = plan(number, home)
    path = made.write()
    there, kind, words = set(Path(root).rglob("*")), "executed", ""
    try:
        saved = home / "saved.npz"
        run(path, "mujoco", 0.05).save(saved)
        load_episode(saved)
    except WmsError as error:
        kind, words = "refused", error.render()
    except Exception as error:  # noqa: BLE001  that is what is looked for
        kind, words = "failed", f"{type(error).__name__}: {error}"[:300]
    if new := [p for p in set(Path(root).rglob("*")) - there if not p.is_relative_to(home)]:
        kind, words = "failed", f"written outside: {new}"
    if SECRET in words:
        kind = "failed"
    return Outcome(number, tuple(made.twists), kind, words, perf_counter() - begin, memory())


def secrets(root: Path) -> Path:
    """Make a folder below others with files that nothing in it may read or change."""
    home = root / "a" / "b" / "c"
    home.mkdir(parents=True)
    for name in ("secret.usda", "secret.png"):
        (home.parent.parent / name).write_text(SECRET)
    return home


def memory() -> int:
    """Return the most memory that this process or one of its children has held, in bytes."""
    return max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)) * 1024


def try_all(
    work: Callable[[int, str], Outcome],
    numbers: range,
    max_time: float,
    verbose: bool = False,
    keep: Callable[[int, Path], object] = lambda *_: None,
) -> list[Outcome]:
    """Try one by one for at most `max_time` seconds; a process that hangs or crashes is replaced.

    `keep` gets each number and folder before that is removed.
    """
    outcomes, end = list[Outcome](), perf_counter() + max_time
    helper = HelperProcess(SECONDS)
    try:
        for number in numbers:
            if perf_counter() > end:
                break
            if len(outcomes) % TOGETHER == TOGETHER - 1 or (outcomes and outcomes[-1].memory > BYTES / 2):
                helper.close()
                helper = HelperProcess(SECONDS)
            root, begin = tempfile.mkdtemp(prefix="stage"), perf_counter()
            made = helper.do(work, number, root)
            keep(number, Path(root))
            shutil.rmtree(root)
            if isinstance(made, JobFailure):
                made = Outcome(number, (), "failed", f"{made.kind}: {made.reason}", perf_counter() - begin, 0)
            elif made.memory > BYTES:
                made = made._replace(kind="failed", words=f"{made.memory >> 20} MB")
            outcomes.append(made)
            if verbose:
                words = " ".join(made.words.split())[:160]
                print(f"{number} {made.kind} {made.seconds:.2f} s ({', '.join(made.twists)}) {words}", flush=True)
            if made.kind == "failed":
                print(f"{number} ({', '.join(made.twists)}): {made.words}", flush=True)
    finally:
        helper.close()
    return outcomes


def main() -> None:
    """Try stages, print the figures and the failures; the exit code is 1 if there are failures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--max-time", type=float, default=36_000.0, help="seconds after which no stage is begun")
    parser.add_argument("--verbose", action="store_true", help="print every stage")
    options = parser.parse_args()
    from benchmarks.hostile_stages import attempt as work  # by its name, so that the process finds it

    numbers = range(options.first, options.first + options.count)
    outcomes = try_all(work, numbers, options.max_time, options.verbose)
    print_figures(outcomes, "stages", "executed")
    sys.exit(any(outcome.kind == "failed" for outcome in outcomes))


def print_figures(outcomes: Sequence[Outcome], what: str, done: str) -> None:
    """Print a table of outcomes of `what`, of which some are `done`."""
    counts = Counter(outcome.kind for outcome in outcomes)
    print(f"| {what} | {done} | refused | failed | slowest | most memory |\n|---|---|---|---|---|---|")
    cells = (len(outcomes), *(counts[kind] for kind in (done, "refused", "failed")))
    slowest, most = (max(getattr(outcome, name) for outcome in outcomes) for name in ("seconds", "memory"))
    print(f"| {' | '.join(f'{cell:,}' for cell in cells)} | {slowest:.2f} s | {most >> 20} MB |")


if __name__ == "__main__":
    main()
