"""Completeness: files match the manifest, and every question is kept or rejected with a reason."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from wmspec.dataset.audit.cases import Case, Unit
from wmspec.dataset.audit.model import Counts, Finding
from wmspec.dataset.build import files
from wmspec.dataset.build.plan import QUESTIONS
from wmspec.dataset.build.reader import REPAIR_HINT, DatasetReader
from wmspec.runtime.questions.model import FAILED


def counts(dataset: DatasetReader, task: str) -> Counts:
    """Return the manifest's counts of a task."""
    recorded = dataset.manifest["tasks"][task]
    kept, rejected = sum(recorded["rows"].values()), dict(recorded["rejected"])
    return Counts(task, recorded["dimension"], recorded["instances"], kept + sum(rejected.values()), kept, rejected)


def check_files(dataset: DatasetReader) -> list[Finding]:
    """Check every file against the hashes of the manifest. Each task with damaged files fails, with a list of them.

    The card and the Croissant metadata must exist as well.
    """
    wrong: dict[str, list[str]] = {}
    for path, why in dataset.damaged().items():
        wrong.setdefault(Path(path).parent.name, []).append(f"{path} {why}")
    findings = [
        Finding("files", task, "fails", f"{'; '.join(those)}. The task was not checked further; {REPAIR_HINT}")
        for task, those in wrong.items()
    ]
    gone = [name for name in (files.CARD, files.CROISSANT) if not (dataset.folder / name).is_file()]
    findings += [Finding("files", "", "fails", f"{name} is missing; {REPAIR_HINT}") for name in gone]
    return findings or [
        Finding("files", "", "holds", f"{len(dataset.manifest['shards']):,} files are as they were written")
    ]


def check_rows(dataset: DatasetReader, counts: Counts, units: list[Unit]) -> Iterator[Finding]:
    """Check that a task's rows match the counts of the manifest, each with one true option."""
    rows = [case for unit in units for case in unit.cases]
    there = Counter(c.row["engine"] if dataset.rows_of == "engines" else QUESTIONS for c in rows)
    recorded = dataset.manifest["tasks"][counts.task]["rows"]
    wrong = [f"{there[name]:,} rows, {n:,} in the manifest" for name, n in recorded.items() if there[name] != n]
    twice = [name for name, n in Counter(c.row["id"] for c in rows).items() if n > 1]
    odd = [c.row["id"] for c in rows if not _one_truth(c)]
    wrong += [f"{len(twice):,} rows have the id of another, such as {twice[0]}"] if twice else []
    wrong += [f"{len(odd):,} rows have no or another true option, such as {odd[0]}"] if odd else []
    if wrong:
        yield Finding("counts", counts.task, "fails", "; ".join(wrong))
    yield _rejection_finding(counts)


def _one_truth(case: Case) -> bool:
    kinds, answer = case.row["option_kind"], case.row["answer"]
    if case.open:
        return answer is None
    return [i for i, kind in enumerate(kinds) if kind == "truth"] == [answer]


def _rejection_finding(counts: Counts) -> Finding:
    """Return the finding about rejections. A task without questions fails, and one with failures."""
    reasons = ", ".join(f"{n:,} {reason}" for reason, n in counts.rejected.items())
    lost = counts.questions - counts.kept
    share = f"{counts.kept:,} of {counts.questions:,} questions kept of {counts.instances:,} instances"
    what = f"{share}; rejected {lost / max(1, counts.questions):.1%}: {reasons}" if lost else f"{share}, none rejected"
    broken = sum(counts.rejected.get(reason, 0) for reason in FAILED)
    return Finding("counts", counts.task, "fails" if not counts.kept or broken else "holds", what)
