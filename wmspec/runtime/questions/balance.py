"""Balanced answers: draws of each group are tried until each answer is equally frequent in every batch of groups.

A batch has as many groups as there are answers. It is computed independently, so the result depends on the design only,
not on the order of work or on other shards.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from operator import add

from wmspec.compile.design.design import Design
from wmspec.core.limits import MAX_DRAWS
from wmspec.runtime.questions.closed_sets import Answers
from wmspec.runtime.questions.model import QuestionRow, Rejected

#: Number of partial assignments followed per batch.
MAX_ASSIGNMENTS = 20_000

#: Answers of the members of a group, by index.
Group = Mapping[int, Answers]
#: Frequency of each answer in a group.
Counts = tuple[int, ...]
#: Computes the answers of all members of a group of a design.
Ask = Callable[[Design, int], Group]


@dataclass(frozen=True)
class BalanceBatch:
    """The answers of all members of a batch, and the numbers of executed and kept groups."""

    answers: Group
    executed: int
    kept: int


def balanced_batch(design: Design, block: int, ask: Ask) -> BalanceBatch:
    """Return the batch of a group with balanced draws; all are rejected if there are none.

    One draw of each group is tried in turn, and the first valid combination is kept. A draw counts if every member
    yields the question, by the answers of the first engine.
    """
    lap, tried = design.balance_batch(block), _TriedDraws(design)
    most = len(design.blocks.members(block))  # groups of a batch: as many as answers, of equal size
    ways: list[dict[Counts, Group]] = [{} for _ in lap]
    first: dict[int, Answers] = {}
    for draw in range(MAX_DRAWS):
        for place, group in enumerate(lap):
            answers = ask(design.redrawn(draw), group)
            counts = tried.counts(answers)
            if draw == 0:
                first.update(answers)
            if counts is None or counts in ways[place]:
                continue
            ways[place][counts] = answers
            kept = pick_assignment(ways, most)
            if kept is not None:
                pairs = zip(ways, kept, strict=True)
                members = {index: answers for way, one in pairs for index, answers in way[one].items()}
                return BalanceBatch(members, tried.groups, len(lap))
    return BalanceBatch(dict(tried.rejected(first)), tried.groups, 0)


def pick_assignment(ways: Sequence[Mapping[Counts, object]], most: int) -> tuple[Counts, ...] | None:
    """Return one option per group such that no answer occurs more than `most` times, or None.

    Earlier options are preferred, those of earlier groups first.
    """
    reached: dict[Counts, tuple[Counts, ...]] = {}
    for place, of_group in enumerate(ways):
        if place == 0:
            reached = {counts: (counts,) for counts in of_group if max(counts) <= most}
            continue
        further: dict[Counts, tuple[Counts, ...]] = {}
        for total, chosen in reached.items():
            for counts in of_group:
                sum_ = tuple(map(add, total, counts))
                if max(sum_) <= most:
                    further.setdefault(sum_, (*chosen, counts))
        reached = dict(islice(further.items(), MAX_ASSIGNMENTS))
    return next(iter(reached.values()), None)


class _TriedDraws:
    """Statistics of the tried draws."""

    def __init__(self, design: Design) -> None:
        names = [question.name for question in design.spec.questions]
        self._design, self._question = design, names.index(design.spec.plan.balance)
        self.groups = 0
        self._words: dict[str, str] = {}
        self._answers: Counter[str] = Counter()
        self._reasons: Counter[str] = Counter()

    def counts(self, group: Group) -> Counts | None:
        """Return the frequency of each answer in a group; None if a member does not yield the question."""
        self.groups += 1
        own = [next(a for a in answers if a.question == self._question) for answers in group.values()]
        lost = [answer for answer in own if isinstance(answer, Rejected)]
        if lost:
            self._reasons[lost[0].reason] += 1
            return None
        rows = [answer for answer in own if isinstance(answer, QuestionRow)]
        truths = Counter(row.options[row.answer].name for row in rows if row.answer is not None)
        self._words = self._words or {option.name: option.text or option.name for option in rows[0].options}
        self._answers.update(truths)
        return tuple(truths[name] for name in sorted(self._words))

    def rejected(self, group: Group) -> Iterator[tuple[int, Answers]]:
        """Yield the answers of instances without the question, because no draws are balanced."""
        came = [f"{words} {self._answers[name]}" for name, words in sorted(self._words.items())]
        lost = [f"rejected {reason} {count}" for reason, count in sorted(self._reasons.items())]
        why = f"{self.groups} draws gave {', '.join([*came, *lost])}: no combination has equally frequent answers"
        for index, answers in group.items():
            yield index, [self._unbalanced(answer, why) for answer in answers]

    def _unbalanced(self, answer: QuestionRow | Rejected, why: str) -> QuestionRow | Rejected:
        if answer.question != self._question or isinstance(answer, Rejected):
            return answer
        return Rejected(answer.task, answer.index, answer.question, answer.engine, "balance", why, answer.label)
