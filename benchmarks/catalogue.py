"""Generate the whole catalogue in three engines, spec by spec, and record what each spec gives.

    python -m benchmarks.catalogue FOLDER [--specs NAME ...] [--shard I/N] [--size 256] [--workers 1] [--minutes 60]
                                          [--audits REPORTS]

Every spec is generated into FOLDER with all of its instances, or with share I of N of them, verified, recorded in
`catalogue.json` beside this file, and deleted. With `--audits`, its audit with the pictures of 400 instances goes into
REPORTS first. What is recorded is not repeated, and a run that was cut off resumes with the same command. No spec is
begun after the given number of minutes. The page docs/benchmarks/catalogue.md is rewritten after each spec.
"""

from __future__ import annotations

import argparse
import json
import resource
import shutil
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from fractions import Fraction
from itertools import groupby
from pathlib import Path

from wmspec.lang.parse.files import catalogue_folders

RECORD = Path(__file__).with_suffix(".json")
PAGE = Path(__file__).parent.parent / "docs/benchmarks/catalogue.md"
#: Rows of a spec that `wmspec verify` executes again; each share of it executes its part of them.
SAMPLE = 8
#: The share that is a whole spec.
WHOLE = "1/1"
#: Figures that are summed over the pieces of a spec.
FIGURES = ("instances", "questions", "size")
HEAD = """# The whole catalogue in three engines

This page shows what the shipped specs give if three engines must agree: how many questions are kept, why others are
rejected, and what this costs. `python -m benchmarks.catalogue FOLDER` writes it. It generates every instance of each
spec in MuJoCo, PyBullet and SAPIEN, keeps the questions that have the same answer in all three, and verifies the
dataset. A spec file has one to three tasks, and an instance may have several questions.

Each number of rejected questions has the name of the [gate](../questions.md#gates) that rejected them. Processor time
is that of all processes of `wmspec generate`; the machine also ran other programs. A spec may have changed since the
date of its row, and other pages have figures of other dates.

"""


@dataclass(frozen=True)
class Piece:
    """What a spec, or a `shard` of it, gave: `rejected` counts reasons, `size` is in bytes, `seconds` of processors.

    `seconds` is 0 for a piece that was cut off and resumed, because only the last part was measured.
    """

    spec: str
    tasks: int
    instances: int
    questions: int
    rejected: dict[str, int]
    failed: int
    size: int
    seconds: float
    pixels: int
    versions: dict[str, str]
    date: str
    shard: str = WHOLE

    @property
    def share(self) -> Fraction:
        """The share of the instances of the spec."""
        return Fraction(1, parts(self.shard))


def main() -> None:
    """Generate what is not recorded, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="for datasets")
    parser.add_argument("--specs", nargs="*", metavar="NAME", help="such as perception/vision/color")
    parser.add_argument("--shard", default=WHOLE, metavar="I/N", help="only share I of N of each spec's instances")
    parser.add_argument("--size", type=int, default=256, help="pixels on a side")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--audits", type=Path, metavar="REPORTS", help="folder for audits")
    options = parser.parse_args()
    paths = {
        str(path.relative_to(folder.parent).with_suffix("")): path
        for folder in catalogue_folders()
        for path in sorted(folder.rglob("*.wms"))
    }
    if unknown := set(options.specs or ()) - set(paths):
        sys.exit(f"there is no spec {', '.join(sorted(unknown))}")
    until = time.monotonic() + 60 * options.minutes
    for name in options.specs or paths:
        pieces = recorded()
        if any(piece.spec == name and piece.shard in (options.shard, WHOLE) for piece in pieces):
            continue
        if time.monotonic() > until:
            break
        file = (name if options.shard == WHOLE else f"{name}/{options.shard}").replace("/", "-")
        pieces.append(generated(name, paths[name], options.folder / file, options))
        if options.audits:
            audit(options.folder / file, options.audits / file, options.workers)
        shutil.rmtree(options.folder / file)
        pieces.sort(key=lambda piece: (list(paths).index(piece.spec), piece.shard))
        RECORD.write_text(json.dumps([asdict(piece) for piece in pieces], indent=1, ensure_ascii=False) + "\n")
        PAGE.write_text(HEAD + page(pieces, len(paths)))
        print(row([piece for piece in pieces if piece.spec == name]), flush=True)


def parts(shard: str) -> int:
    """Return the number of shares of which `shard`, such as `1/4`, is one."""
    return int(shard.partition("/")[2])


def recorded() -> list[Piece]:
    """Return the pieces of earlier runs."""
    return [Piece(**piece) for piece in json.loads(RECORD.read_text())] if RECORD.exists() else []


def generated(name: str, spec: Path, out: Path, options: argparse.Namespace) -> Piece:
    """Generate the instances of a spec, or a share of them, in three engines, and verify the dataset."""
    resumed = out.exists()
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run, workers = [sys.executable, "-m", "wmspec"], ["-j", str(options.workers)]
    shard = [] if options.shard == WHOLE else ["--shard", options.shard]
    command = [*run, "generate", str(spec), "-o", str(out), "-b", "all", "--size", str(options.size), *shard, *workers]
    done = subprocess.run([*command, "--json"], check=True, stdout=subprocess.PIPE, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    verify = [*run, "verify", str(out), "--sample", str(-(-SAMPLE // parts(options.shard))), *workers]
    subprocess.run(verify, check=True, stdout=subprocess.DEVNULL)
    tasks = json.loads(done.stdout)
    reasons = Counter[str]()
    for task in tasks:
        reasons.update(task["rejected"])
    return Piece(
        name,
        len(tasks),
        sum(task["instances"] for task in tasks),
        sum(task["rows"].get("questions", 0) for task in tasks),
        dict(sorted(reasons.items())),
        sum(task["failed"] for task in tasks),
        sum(path.stat().st_size for path in out.rglob("*") if path.is_file()),
        0.0 if resumed else after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
        options.size,
        json.loads((out / "manifest.json").read_text())["versions"],
        datetime.now(UTC).date().isoformat(),
        options.shard,
    )


def audit(dataset: Path, report: Path, workers: int) -> None:
    """Audit a dataset. What the audit finds does not stop the run."""
    command = [sys.executable, "-m", "wmspec", "audit", str(dataset), "--max-images", "400", "-o", str(report)]
    subprocess.run([*command, "-j", str(workers)], check=False, stdout=subprocess.DEVNULL)


def page(pieces: list[Piece], count: int) -> str:
    """Return the table of the pieces, of `count` specs in all."""
    instances, questions = (sum(getattr(piece, name) for piece in pieces) for name in ("instances", "questions"))
    rejected = sum(sum(piece.rejected.values()) for piece in pieces)
    versions = {f"{name} {version}" for piece in pieces for name, version in piece.versions.items()}
    size, hours = sum(piece.size for piece in pieces) / 1e9, sum(piece.seconds for piece in pieces) / 3600
    specs = [list(group) for _, group in groupby(pieces, key=lambda piece: piece.spec)]
    whole = sum(sum(piece.share for piece in spec) == 1 for spec in specs)
    done = f"{whole} of {count} specs, {instances:,} instances, {questions:,} questions kept, {rejected:,} rejected"
    heads = "| spec | tasks | instances | questions kept | questions rejected | size (MB) "
    lines = [
        f"{done}, {size:.1f} GB, {hours:.1f} hours of processor time, with {', '.join(sorted(versions))}.",
        "",
        f"{heads}| processor time per instance | date |",
        "|---|---:|---:|---:|---|---:|---:|---|",
        *map(row, specs),
    ]
    return "\n".join(lines) + "\n"


def row(pieces: Sequence[Piece]) -> str:
    """Return a row of the table: a spec, given its pieces."""
    counts = Counter[str]()
    for piece in pieces:
        counts.update(piece.rejected | ({"failed": piece.failed} if piece.failed else {}))
    reasons = ", ".join(f"{count} {reason}" for reason, count in sorted(counts.items())) or "0"
    instances, questions, size = (sum(getattr(piece, name) for piece in pieces) for name in FIGURES)
    timed = [piece for piece in pieces if piece.seconds]
    seconds, measured = (sum(getattr(piece, name) for piece in timed) for name in ("seconds", "instances"))
    each = f"{seconds / measured * 1000:.0f} ms" if timed else "resumed"
    share, first = sum(piece.share for piece in pieces), pieces[0]
    spec = f"`{first.spec}`" + ("" if share == 1 else f", {share} of it")
    tasks, date = max(piece.tasks for piece in pieces), max(piece.date for piece in pieces)
    return f"| {spec} | {tasks} | {instances:,} | {questions:,} | {reasons} | {size / 1e6:,.0f} | {each} | {date} |"


if __name__ == "__main__":
    main()
