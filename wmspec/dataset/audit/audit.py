"""The audit of a dataset: every check of every task, one task in the memory of a process at a time."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from wmspec.core.diagnostics import WmsError
from wmspec.dataset.audit import balance, groups, probes
from wmspec.dataset.audit.cases import Enlarging, Unit, task_of, units
from wmspec.dataset.audit.counts import accounted, counts, whole
from wmspec.dataset.audit.duplicates import duplicates, enlarged, judged
from wmspec.dataset.audit.image_similarity import QUANTILES, judge, likeness
from wmspec.dataset.audit.model import Audit, Counts, Finding, Likeness, Probe, Spread, Summary, Test
from wmspec.dataset.audit.stability import stability
from wmspec.dataset.audit.summary import summary
from wmspec.dataset.build.reader import DatasetReader
from wmspec.runtime.workers.pool import Effort, Lost, in_order

#: A task that takes longer (s) than this is given up.
LONGEST = 24 * 3600.0

#: The order of verdicts: what matters first.
_ORDER = ("fails", "unclear", "told", "holds")


@dataclass
class _Gathered:
    findings: list[Finding] = field(default_factory=list)
    counts: list[Counts] = field(default_factory=list)
    tests: list[Test] = field(default_factory=list)
    probes: list[Probe] = field(default_factory=list)
    likeness: list[Likeness] = field(default_factory=list)
    spreads: list[Spread] = field(default_factory=list)
    groups: dict[str, int] = field(default_factory=dict)
    stable: dict[str, float | None] = field(default_factory=dict)

    def add(self, other: _Gathered) -> None:
        """Take in what was gathered of another task."""
        for mine, its in zip(vars(self).values(), vars(other).values(), strict=True):
            mine.update(its) if isinstance(mine, dict) else mine.extend(its)


def audit(folder: Path, most: int, progress: Callable[[str, int], None], workers: int = 0) -> Audit:
    """Look at everything in a finished dataset, at the pictures of at most `most` instances of each task.

    Tasks are shared among so many `workers`, or done in this process if there are none: what is found is the same. Of a
    task that has a damaged file nothing else is looked at. `progress` is told of every task that is done. Raises
    WmsError if there is no finished dataset in the folder, or if a file of it may not be read.
    """
    dataset = DatasetReader.open(folder)
    gathered = _Gathered(whole(dataset))
    damaged = {finding.task for finding in gathered.findings if finding.verdict == "fails"}
    pieces = [(dataset, task, most, task in damaged) for task in dataset.tasks]
    with closing(_done(pieces, min(workers, len(pieces)))) as done:
        for task, found in zip(dataset.tasks, done, strict=True):
            if isinstance(found, Lost):
                raise WmsError(f"the audit of `{task}` came to nothing: {found.reason}")
            gathered.add(found)
            progress(task, 1)
    tests, probed = balance.weighed(gathered.tests), probes.weighed(gathered.probes)
    probed.sort(key=lambda p: p.chance - p.accuracy)
    gathered.findings += [*map(balance.judge, tests), *map(probes.judge, probed)]
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


def _done(pieces: list[tuple[DatasetReader, str, int, bool]], workers: int) -> Generator[_Gathered | Lost, None, None]:
    """What is found of every task, in order."""
    if workers > 1:
        yield from in_order(_task, pieces, Effort(workers, LONGEST))
    else:
        yield from (_task(*piece) for piece in pieces)


def _task(dataset: DatasetReader, task: str, most: int, damaged: bool) -> _Gathered:
    gathered, counted = _Gathered(), counts(dataset, task)
    gathered.counts.append(counted)
    if damaged:
        return gathered
    parts = list(units(dataset, task, most))
    gathered.findings += accounted(dataset, counted, parts)
    finding, gathered.stable[task] = stability(dataset, task, parts)
    gathered.findings.append(finding)
    for unit in parts:
        _unit(unit, Enlarging(dataset, task), gathered)
    return gathered


def _unit(unit: Unit, pictures: Enlarging, gathered: _Gathered) -> None:
    pairs = enlarged(unit, duplicates(unit), pictures)
    gathered.findings += judged(unit, pairs)
    gathered.groups[unit.name] = groups.effective(unit, pairs)
    gathered.findings.append(groups.judge(unit, gathered.groups[unit.name]))
    alike = likeness(unit)
    gathered.findings.append(judge(unit, alike))
    gathered.likeness += [alike] if alike else []
    gathered.tests += balance.tests(unit)
    probed = probes.probes(unit)
    if not probed and not unit.open:
        few = f"{len(unit.once):,} instances of {unit.draws:,} groups are too few to look for shortcuts"
        gathered.findings.append(Finding("shortcut", unit.name, "unclear", few))
    gathered.probes += probed
    gathered.spreads += _spreads(unit)


def _summary(counted: Counts, gathered: _Gathered, probed: list[Probe]) -> Summary:
    """A task in one line; its questions have its name, and a number if there are several."""
    return summary(
        counted.task,
        counted.kept,
        {name: count for name, count in gathered.groups.items() if task_of(name) == counted.task},
        [f for f in gathered.findings if task_of(f.task) == counted.task],
        [p for p in probed if task_of(p.task) == counted.task],
        gathered.stable.get(counted.task),
    )


def _spreads(unit: Unit) -> list[Spread]:
    """How the stimulus differences are spread, where rows have them."""
    values: dict[tuple[str, str], list[float]] = {}
    for difference in (case.row.get("difference") for case in unit.once):
        if difference is not None:
            values.setdefault((difference["name"], difference["unit"]), []).append(difference["value"])
    return [
        Spread(unit.name, name, unit_, tuple(float(q) for q in np.quantile(seen, QUANTILES)))
        for (name, unit_), seen in values.items()
    ]
