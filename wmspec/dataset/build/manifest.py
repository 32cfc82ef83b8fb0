"""The manifest and summary of a finished dataset."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from wmspec.compile.design.design import Design
from wmspec.core.crash import Crash
from wmspec.core.tally import Tally
from wmspec.dataset.build.plan import QUESTIONS, Plan, Task, row_names
from wmspec.dataset.build.shards import Record, shard_entry
from wmspec.dataset.build.splits import declared_holdouts
from wmspec.dataset.build.worker import Balance, CacheStats
from wmspec.runtime.questions.model import FAILED, Rejected

#: Maximum number of rejection reasons in a summary.
MAX_REASONS = 3


@dataclass(frozen=True)
class TaskSummary:
    """The counts of a task: instances, rows, rejections by reason with the first example of each.

    `rows` are counted by engine if each engine has its own (see `row_names`). `failed` instances ended as internal
    errors, crashes or timeouts, not by a gate.
    """

    name: str
    instances: int
    rows: dict[str, int]
    rejected: dict[str, int]
    examples: dict[str, Rejected]
    failed: int = 0

    def __str__(self) -> str:
        """Return the number of questions kept and the main rejection reasons."""
        kept = f"{self.name}: {sum(self.rows.values()):,} questions of {self.instances:,} instances"
        return "\n".join([kept, *top_reasons(self.rejected, self.examples).values()])


def top_reasons(rejected: Mapping[str, int], examples: Mapping[str, Rejected]) -> dict[str, str]:
    """Return the most frequent rejection reasons, each with a line that has an example."""
    often = sorted(rejected.items(), key=lambda one: (-one[1], one[0]))[:MAX_REASONS]
    return {reason: f"  {n:,} {reason}, such as {describe(examples[reason])}" for reason, n in often}


def by_reason(lost: Sequence[Rejected]) -> tuple[dict[str, int], dict[str, Rejected]]:
    """Return the number of rejections by reason, and the first of each."""
    counted = Counter(str(r.reason) for r in lost)
    return dict(sorted(counted.items())), {str(r.reason): r for r in reversed(lost)}


def describe(one: Rejected) -> str:
    """Return a rejection in words."""
    question = f" question {one.question + 1}" if one.question else ""
    return f"instance {one.index}{question} in {one.engine}: {one.detail}"


@dataclass(frozen=True)
class Summary:
    """The counts of a whole dataset, with the cache statistics and balancing cost of this run.

    `crash` is the first unexpected error of this run.
    """

    tasks: tuple[TaskSummary, ...]
    shared: CacheStats = field(default_factory=CacheStats)
    balance: Mapping[str, Balance] = field(default_factory=dict)
    crash: Crash | None = None

    @property
    def tally(self) -> Tally:
        """Whether it was worth making: questions were kept, and few instances failed."""
        tried, failed = sum(t.instances for t in self.tasks), sum(t.failed for t in self.tasks)
        return Tally("question was kept", self.rows, "instances", tried, failed, self._cause)

    @property
    def _cause(self) -> str:
        """The first failure in full."""
        if self.crash is not None:
            return self.crash.report()
        return next((describe(t.examples[r]) for t in self.tasks for r in sorted(FAILED) if r in t.examples), "")

    @property
    def rows(self) -> int:
        """The number of questions kept."""
        return sum(sum(t.rows.values()) for t in self.tasks)

    @property
    def rejected(self) -> dict[str, int]:
        """The number of questions rejected, by reason."""
        total: Counter[str] = Counter()
        for task in self.tasks:
            total.update(task.rejected)
        return dict(sorted(total.items()))

    def __str__(self) -> str:
        lost = sum(self.rejected.values())
        why = ", ".join(f"{n:,} {reason}" for reason, n in self.rejected.items())
        count = f"{self.rows:,} questions, {lost:,} rejected" + (f" ({why})" if why else "")
        cost = [f"{task}: {balance}" for task, balance in self.balance.items()]
        return "\n".join([*map(str, self.tasks), *cost, *([str(self.shared)] if self.shared.episodes else []), count])


def summary(plan: Plan, records: Mapping[str, Record]) -> Summary:
    """Return the counts from shard records. `records` has every shard of the plan by its path."""
    lost: dict[str, list[Rejected]] = {task.spec.name: [] for task in plan.tasks}
    for shard in plan.shards():
        lost[shard.task.spec.name] += records[shard.path].rejected
    return Summary(tuple(_count(plan, task, lost[task.spec.name]) for task in plan.tasks))


def _count(plan: Plan, task: Task, lost: list[Rejected]) -> TaskSummary:
    planned = len(task.indices) * len(task.spec.questions)
    by_engine = Counter(r.engine if plan.rows_of == "engines" else QUESTIONS for r in lost)
    rows = {name: planned - by_engine[name] for name in row_names(plan.rows_of, plan.engines)}
    failed = len({r.index for r in lost if r.reason in FAILED})
    return TaskSummary(task.spec.name, len(task.indices), rows, *by_reason(lost), failed)


def manifest(
    plan: Plan, records: Mapping[str, Record], total: Summary, others: Mapping[str, str] | None = None
) -> dict[str, Any]:
    """Return the manifest as JSON values: plan with spec texts, counts, rejections, shards and other files.

    `others` are the SHA-256 hashes of the files that are no shards, by path.
    """
    record = plan.record
    shards = [(s.path, records[s.path]) for s in plan.shards()]
    return {
        "format": record["format"],
        "fingerprint": plan.fingerprint,
        **{key: record[key] for key in ("versions", "seed", "engines", "size", "consensus", "rows_of", "shard")},
        **({"profile": plan.profile} if plan.profile else {}),
        **({"part": list(plan.part)} if plan.part != (1, 1) else {}),
        **({"split": plan.split.record} if plan.split else {}),
        **({"film": plan.film.record} if plan.film else {}),
        "licence": plan.licence,
        "specs": {name: {"sha256": sha, "text": plan.texts[name]} for name, sha in record["specs"].items()},
        "tasks": {t.spec.name: _task(plan, t, c) for t, c in zip(plan.tasks, total.tasks, strict=True)},
        "rows": total.rows,
        "rejected": {"count": total.rejected, "list": [asdict(r) for _, s in shards for r in s.rejected]},
        "shards": {path: shard_entry(record) for path, record in shards},
        "files": dict(others or {}),
    }


def _task(plan: Plan, task: Task, count: TaskSummary) -> dict[str, Any]:
    spec = task.spec
    about = {key: getattr(spec, key) for key in ("dimension", "title", "description", "license", "source")}
    selected = {"selected": task.selected} if plan.part != (1, 1) and task.selected is not None else {}
    counts = {"instances": count.instances, **selected, "rows": count.rows, "rejected": count.rejected}
    return {**about, **counts, **_splits(plan, task)}


def _splits(plan: Plan, task: Task) -> dict[str, Any]:
    """Return what splits of the rows depend on: hold-outs, and the control groups that are balanced together."""
    holdouts = declared_holdouts(task.spec)
    made: dict[str, Any] = {"holdouts": holdouts} if holdouts else {}
    if task.spec.plan.balance:
        design = Design(task.spec, plan.seed)
        batches = {tuple(sorted(design.balance_batch(design.block_of(index)))) for index in task.indices}
        made["balance_batches"] = [list(batch) for batch in sorted(batches)]
    return made
