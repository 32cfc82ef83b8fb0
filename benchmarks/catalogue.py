"""Generate the whole catalogue in three engines, spec by spec, and record what each spec gives.

    python -m benchmarks.catalogue FOLDER [--specs NAME ...] [--size 256] [--workers 1] [--minutes 60]
                                          [--audits REPORTS]

Every spec is generated into FOLDER with all of its instances, verified, recorded in `catalogue.json` beside this file,
and deleted. With `--audits`, its audit with the pictures of 400 instances goes into REPORTS first. Specs that are
recorded are not repeated, and a run that was cut off resumes with the same command. No spec is begun after the given
number of minutes. The page docs/benchmarks/catalogue.md is rewritten after each spec.
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
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path

from wmspec.lang.parse.files import catalogue_folders

RECORD = Path(__file__).with_suffix(".json")
PAGE = Path(__file__).parent.parent / "docs/benchmarks/catalogue.md"
#: Rows that `wmspec verify` executes again.
SAMPLE = 20
HEAD = """# The whole catalogue in three engines

`python -m benchmarks.catalogue FOLDER` generates every instance of a spec in MuJoCo, PyBullet and SAPIEN, keeps the
questions that have one answer in all of them, and verifies the dataset. Processor time is that of all processes of the
command, beside other work of the machine. A spec may have changed since the date of its row.

"""


@dataclass(frozen=True)
class Piece:
    """What a spec gave: `rejected` counts reasons, `size` is in bytes, `seconds` are of processors.

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


def main() -> None:
    """Generate what is not recorded, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="for datasets")
    parser.add_argument("--specs", nargs="*", metavar="NAME", help="such as perception/vision/color")
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
        if name in {piece.spec for piece in pieces}:
            continue
        if time.monotonic() > until:
            break
        file = name.replace("/", "-")
        pieces.append(generated(name, paths[name], options.folder / file, options.size, options.workers))
        if options.audits:
            audit(options.folder / file, options.audits / file, options.workers)
        shutil.rmtree(options.folder / file)
        pieces.sort(key=lambda piece: list(paths).index(piece.spec))
        RECORD.write_text(json.dumps([asdict(piece) for piece in pieces], indent=1, ensure_ascii=False) + "\n")
        PAGE.write_text(HEAD + page(pieces, len(paths)))
        print(row(pieces[[piece.spec for piece in pieces].index(name)]), flush=True)


def recorded() -> list[Piece]:
    """Return the pieces of earlier runs."""
    return [Piece(**piece) for piece in json.loads(RECORD.read_text())] if RECORD.exists() else []


def generated(name: str, spec: Path, out: Path, size: int, workers: int) -> Piece:
    """Generate all instances of a spec in three engines, and verify the dataset."""
    resumed = out.exists()
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "wmspec", "generate", str(spec), "-o", str(out), "-b", "all", "--size", str(size)]
    done = subprocess.run([*command, "-j", str(workers), "--json"], check=True, stdout=subprocess.PIPE, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    verify = [sys.executable, "-m", "wmspec", "verify", str(out), "--sample", str(SAMPLE), "-j", str(workers)]
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
        size,
        json.loads((out / "manifest.json").read_text())["versions"],
        datetime.now(UTC).date().isoformat(),
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
    done = f"{len(pieces)} of {count} specs, {instances:,} instances, {questions:,} questions, {rejected:,} rejected"
    lines = [
        f"{done}, {size:.1f} GB, {hours:.1f} hours of a core, with {', '.join(sorted(versions))}.",
        "",
        "| spec | tasks | instances | questions | rejected | MB | a core's time for each | date |",
        "|---|---:|---:|---:|---|---:|---:|---|",
        *map(row, pieces),
    ]
    return "\n".join(lines) + "\n"


def row(piece: Piece) -> str:
    """Return a row of the table."""
    reasons = ", ".join(f"{count} {reason}" for reason, count in piece.rejected.items()) or "0"
    if piece.failed:
        reasons += f", {piece.failed} failed"
    each = f"{piece.seconds / piece.instances * 1000:.0f} ms" if piece.seconds else "resumed"
    counts = f"{piece.tasks} | {piece.instances:,} | {piece.questions:,} | {reasons}"
    return f"| `{piece.spec}` | {counts} | {piece.size / 1e6:,.0f} | {each} | {piece.date} |"


if __name__ == "__main__":
    main()
