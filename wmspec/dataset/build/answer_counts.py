"""Answers of kept and rejected instances, and whether the gates change their balance."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from wmspec.dataset.build.plan import Plan
from wmspec.dataset.build.reader import DatasetReader
from wmspec.lang.check.ir.ir import Question, TaskSpec
from wmspec.runtime.questions.answer_label import member_label
from wmspec.runtime.questions.kinds import KINDS
from wmspec.runtime.questions.model import Rejected

#: Probability below which a difference between kept and rejected answers is no chance.
SIGNIFICANCE = 0.01
#: Change of the share of an answer by the gates below which there is no warning.
MIN_SHIFT = 0.1
#: Numbers of kept instances, and of their groups, from which a single answer is a mistake.
DOMINANT, DOMINANT_GROUPS = 8, 4


@dataclass(frozen=True)
class AnswerCounts:
    """How often each answer of a question occurs among its kept and its rejected instances, in one engine.

    Instances that are rejected before their answer is known are in neither. `groups` is the number of control groups of
    the kept instances.
    """

    kept: Mapping[str, int] = field(default_factory=dict)
    rejected: Mapping[str, int] = field(default_factory=dict)
    groups: int = 0

    @property
    def answers(self) -> list[str]:
        """All answers in order."""
        return sorted({*self.kept, *self.rejected})

    @property
    def dominant(self) -> str:
        """The answer of all kept instances, if they are at least 8 from at least 4 groups; else ''."""
        only = list(self.kept) if self.groups >= DOMINANT_GROUPS else []
        return only[0] if len(only) == 1 and self.kept[only[0]] >= DOMINANT else ""

    @property
    def shift(self) -> str:
        """How the gates change the balance of answers, in words; '' if they do not.

        The answer whose share changes most is named, if that is by 10 points and unlikely by chance (p < 0.01).
        """
        kept, lost = sum(self.kept.values()), sum(self.rejected.values())
        if not kept or not lost:
            return ""
        before = {a: (self.kept.get(a, 0) + self.rejected.get(a, 0)) / (kept + lost) for a in self.answers}
        after = {a: self.kept.get(a, 0) / kept for a in self.answers}
        most = max(self.answers, key=lambda a: abs(after[a] - before[a]))
        if abs(after[most] - before[most]) < MIN_SHIFT or self._chance() >= SIGNIFICANCE:
            return ""
        return f"the gates change the share of the answer `{most}` from {before[most]:.0%} to {after[most]:.0%}"

    def _chance(self) -> float:
        """Return the probability of such a difference if the gates did not depend on the answer."""
        import numpy as np

        from wmspec.dataset.audit.statistics import independence

        table = [[counts.get(a, 0) for a in self.answers] for counts in (self.kept, self.rejected)]
        return independence(np.array(table, np.int64))[1]


def row_label(question: Question, row: Mapping[str, Any]) -> str:
    """Return the label by which the answer of a row is counted; '' if it is open or one of the pictures."""
    if question.orbit:
        levels = {varied.factor: row[f"factor.{varied.factor}"] for varied in question.orbit}
        return member_label(question, levels, {name: row.get(f"level.{name}") for name in levels})
    return row["answer_value"] if KINDS[question.kind].countable else ""


def label_columns(spec: TaskSpec, columns: Iterable[str]) -> list[str]:
    """Return the columns of a task that labels are made from."""
    factors = {varied.factor for question in spec.questions for varied in question.orbit}
    needed = {
        "engine",
        "question",
        "block",
        "answer_value",
        *(f"{kind}.{f}" for f in factors for kind in ("factor", "level")),
    }
    return [name for name in columns if name in needed]


def count_answers(
    spec: TaskSpec, rows: Iterable[Mapping[str, Any]], rejected: Sequence[Rejected], engine: str = ""
) -> list[AnswerCounts]:
    """Return the counts of every question of a task, in an engine if rows are of engines."""
    kept: list[Counter[str]] = [Counter() for _ in spec.questions]
    lost: list[Counter[str]] = [Counter() for _ in spec.questions]
    blocks: list[set[int]] = [set() for _ in spec.questions]
    for row in rows:
        if engine in ("", row["engine"]):
            blocks[row["question"]].add(row["block"])
            kept[row["question"]][row_label(spec.questions[row["question"]], row)] += 1
    for each in rejected:
        if engine in ("", each.engine):
            lost[each.question][each.answer] += 1
    return [
        AnswerCounts(_known(there), _known(gone), len(own)) for there, gone, own in zip(kept, lost, blocks, strict=True)
    ]


def _known(counts: Counter[str]) -> dict[str, int]:
    """Return the counts of answers that have a label, in order."""
    return {answer: n for answer, n in sorted(counts.items()) if answer}


def balance_shifts(folder: Path, plan: Plan) -> Iterator[str]:
    """Yield a warning for every question of a finished dataset for which the gates change the balance of answers."""
    reader = DatasetReader.open(folder)
    engine = plan.reference if plan.rows_of == "engines" else ""
    rejected = [Rejected(**each) for each in reader.manifest["rejected"]["list"]]
    for task in plan.tasks:
        spec = task.spec
        rows = (
            reader.rows(spec.name, label_columns(spec, reader.columns(spec.name))) if reader.columns(spec.name) else ()
        )
        lost = [each for each in rejected if each.task == spec.name]
        for question, counts in zip(spec.questions, count_answers(spec, rows, lost, engine), strict=True):
            if counts.shift:
                yield f"warning: {spec.name}{f', {question.name}' if question.name else ''}: {counts.shift}"
