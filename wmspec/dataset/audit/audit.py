"""The audit of a dataset: runs every check on every task; each process holds one task at a time."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from wmspec.core.diagnostics import WmsError
from wmspec.dataset.audit import balance, duplicates, metadata, probes
from wmspec.dataset.audit.cases import Unit, full_size_pictures, task_of, units
from wmspec.dataset.audit.constant_answers import constant_answer_finding, what_if_finding
from wmspec.dataset.audit.counts import check_files, check_rows, counts
from wmspec.dataset.audit.given import companion_finding
from wmspec.dataset.audit.image_similarity import QUANTILES, option_similarity, similarity_finding
from wmspec.dataset.audit.legibility import legibility_finding, motion_finding
from wmspec.dataset.audit.model import Audit, Counts, Finding, Likeness, Probe, Spread, Summary, Test
from wmspec.dataset.audit.stability import stability
from wmspec.dataset.audit.vocabulary import vocabulary_finding
from wmspec.dataset.build.reader import DatasetReader
from wmspec.runtime.workers.pool import JobFailure, PoolConfig, map_ordered

#: Timeout for a task (s).
TASK_TIMEOUT = 24 * 3600.0

#: Verdicts, most important first.
_ORDER = ("fails", "unclear", "reported", "holds")

#: Checks of one question that apply to some questions only.
_OPTIONAL = (vocabulary_finding, motion_finding, constant_answer_finding, what_if_finding)


@dataclass
class _Results:
    """The results collected so far."""

    findings: list[Finding] = field(default_factory=list)
    counts: list[Counts] = field(default_factory=list)
    tests: list[Test] = field(default_factory=list)
    probes: list[Probe] = field(default_factory=list)
    likeness: list[Likeness] = field(default_factory=list)
    spreads: list[Spread] = field(default_factory=list)
    groups: dict[str, int] = field(default_factory=dict)
    stable: dict[str, float | None] = field(default_factory=dict)

    def add(self, other: _Results) -> None:
        """Add the results of another task."""
        for mine, its in zip(vars(self).values(), vars(other).values(), strict=True):
            mine.update(its) if isinstance(mine, dict) else mine.extend(its)


def audit(
    folder: Path,
    most: int,
    progress: Callable[[str, int], None],
    workers: int = 0,
    more: Callable[[DatasetReader], list[Finding]] | None = None,
) -> Audit:
    """Run all checks on a finished dataset, with the pictures of at most `most` instances of each task.

    Tasks are distributed over `workers` processes, or run in this one if `workers` is 0; the result is the same. A task
    with a damaged file gets no further checks. `progress` is called after every task. `more` returns the findings of
    further checks. Raises WmsError if the folder holds no finished dataset, or if one of its files may not be read.
    """
    dataset = DatasetReader.open(folder)
    gathered = _Results(check_files(dataset))
    damaged = {finding.task for finding in gathered.findings if finding.verdict == "fails"}
    pieces = [(dataset, task, most, task in damaged) for task in dataset.tasks]
    with closing(_task_results(pieces, min(workers, len(pieces)))) as done:
        for task, found in zip(dataset.tasks, done, strict=True):
            if isinstance(found, JobFailure):
                raise WmsError(f"the audit of `{task}` failed: {found.reason}")
            gathered.add(found)
            progress(task, 1)
    tests, probed = balance.corrected_tests(gathered.tests), probes.with_intervals(gathered.probes)
    probed.sort(key=lambda p: p.chance - p.accuracy)
    gathered.findings += [*map(balance.judge, tests), *map(probes.judge, probed), *(more(dataset) if more else [])]
    made = {key: dataset.manifest.get(key) for key in ("rows", "engines", "size", "seed", "consensus", "versions")}
    return Audit(
        dataset=folder.resolve().name,
        findings=tuple(sorted(gathered.findings, key=lambda f: (_ORDER.index(f.verdict), f.task, f.check))),
        counts=tuple(gathered.counts),
        tests=tuple(tests),
        probes=tuple(probed),
        likeness=tuple(gathered.likeness),
        spreads=tuple(gathered.spreads),
        summaries=tuple(_summary(counted, gathered, probed) for counted in gathered.counts),
        about=made | {"pictures of at most": most},
    )


def _task_results(
    pieces: list[tuple[DatasetReader, str, int, bool]], workers: int
) -> Generator[_Results | JobFailure, None, None]:
    """Yield the results of every task, in order."""
    if workers > 1:
        yield from map_ordered(_audit_task, pieces, PoolConfig(workers, TASK_TIMEOUT))
    else:
        yield from (_audit_task(*piece) for piece in pieces)


def _audit_task(dataset: DatasetReader, task: str, most: int, damaged: bool) -> _Results:
    """Return the results of one task."""
    gathered, counted = _Results(), counts(dataset, task)
    gathered.counts.append(counted)
    if damaged:
        return gathered
    parts = list(units(dataset, task, most))
    gathered.findings += check_rows(dataset, counted, parts)
    finding, gathered.stable[task] = stability(dataset, task, parts)
    gathered.findings.append(finding)
    for unit in parts:
        _audit_unit(unit, parts, partial(full_size_pictures, dataset, task), gathered)
        findings = (companion_finding(parts, unit), legibility_finding(unit), *(find(unit) for find in _OPTIONAL))
        gathered.findings += filter(None, findings)
    gathered.tests += metadata.level_tests(parts[0]) if parts else []
    return gathered


def _audit_unit(unit: Unit, parts: Sequence[Unit], pictures: duplicates.ReadFullSize, gathered: _Results) -> None:
    """Run all checks of one of the questions of a task."""
    pairs = duplicates.mark_faint(unit, duplicates.duplicates(unit), pictures)
    gathered.findings += duplicates.duplicate_findings(unit, pairs)
    gathered.groups[unit.name] = duplicates.effective_groups(unit, pairs)
    gathered.findings.append(duplicates.group_finding(unit, gathered.groups[unit.name]))
    alike = option_similarity(unit)
    gathered.findings.append(similarity_finding(unit, alike))
    gathered.likeness += [alike] if alike else []
    gathered.tests += [*balance.tests(unit), *metadata.answer_tests(unit)]
    probed = probes.probes(unit, parts)
    if not probed and not unit.open:
        few = f"{len(unit.per_instance):,} instances of {unit.draws:,} groups are too few for shortcut probes"
        gathered.findings.append(Finding("shortcut", unit.name, "unclear", few))
    gathered.probes += probed
    gathered.spreads += _spreads(unit)


def _summary(counted: Counts, gathered: _Results, probed: list[Probe]) -> Summary:
    """Return the one-line summary of a task. Its questions have its name, with a number if there are several."""
    task = counted.task
    found = [f for f in gathered.findings if task_of(f.task) == task]
    wrong, unknown = (dict.fromkeys(f.check for f in found if f.verdict == v) for v in ("fails", "unclear"))
    judged = [p for p in probed if p.judged and task_of(p.task) == task]
    best = max(judged, key=lambda p: p.accuracy - p.chance, default=None)
    return Summary(
        task=task,
        verdict="fails" if wrong else "unclear" if unknown else "holds",
        why=tuple(wrong or unknown),
        questions=counted.kept,
        groups=min((count for name, count in gathered.groups.items() if task_of(name) == task), default=0),
        above=best.accuracy - best.chance if best else None,
        best=best.sees if best else "",
        least=max((p.least for p in judged), default=None),
        stable=gathered.stable.get(task),
    )


def _spreads(unit: Unit) -> list[Spread]:
    """Return the distribution of stimulus differences, where rows have them."""
    values: dict[tuple[str, str], list[float]] = {}
    for difference in (case.row.get("difference") for case in unit.per_instance):
        if difference is not None:
            values.setdefault((difference["name"], difference["unit"]), []).append(difference["value"])
    return [
        Spread(unit.name, name, unit_, tuple(float(q) for q in np.quantile(seen, QUANTILES)))
        for (name, unit_), seen in values.items()
    ]
