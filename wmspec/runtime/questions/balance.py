"""Balanced answers: of each group, draws are tried until in every lap of groups each answer comes equally often.

A lap has as many groups as there are answers. It is made by itself, so that what is kept depends on nothing but the
design: not on the order of the work, on who does it, or on what other shares of the design hold.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from operator import add

from wmspec.compile.design.design import Design
from wmspec.core.limits import MOST_DRAWS
from wmspec.runtime.questions.closed_sets import Answers
from wmspec.runtime.questions.model import QuestionRow, Rejected

#: So many ways in which the groups of a lap can come together are followed.
MOST_WAYS = 20_000

#: The answers of a group's members, by index.
Group = Mapping[int, Answers]
#: How often each answer comes in a group.
Counts = tuple[int, ...]
#: Asks all members of a group of a design.
Ask = Callable[[Design, int], Group]


@dataclass(frozen=True)
class Lap:
    """The answers of all members of a lap's groups, how many groups were executed for that, and how many are kept."""

    answers: Group
    executed: int
    kept: int


def balanced(design: Design, block: int, ask: Ask) -> Lap:
    """The lap of a group, with draws in which its answers are balanced; if there are none, they are all rejected.

    Draws are tried in turn, one of each group, and the first are kept that can be. One counts if every member of the
    group yields the question, by the answers of the engine that is named first.
    """
    lap, tried = design.lap(block), _Tried(design)
    most = len(design.blocks.members(block))  # in a whole lap: as many groups as answers, all of one size
    ways: list[dict[Counts, Group]] = [{} for _ in lap]
    first: dict[int, Answers] = {}
    for draw in range(MOST_DRAWS):
        for place, group in enumerate(lap):
            answers = ask(design.redrawn(draw), group)
            counts = tried.counts(answers)
            if draw == 0:
                first.update(answers)
            if counts is None or counts in ways[place]:
                continue
            ways[place][counts] = answers
            kept = together(ways, most)
            if kept is not None:
                pairs = zip(ways, kept, strict=True)
                members = {index: answers for way, one in pairs for index, answers in way[one].items()}
                return Lap(members, tried.groups, len(lap))
    return Lap(dict(tried.rejected(first)), tried.groups, 0)


def together(ways: Sequence[Mapping[Counts, object]], most: int) -> tuple[Counts, ...] | None:
    """One of the ways of each group such that no answer comes more than `most` times; None if there are none such.

    Of several the one whose ways come first, those of the first groups before those of others.
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
        reached = dict(islice(further.items(), MOST_WAYS))
    return next(iter(reached.values()), None)


class _Tried:
    """What came of the draws that were tried."""

    def __init__(self, design: Design) -> None:
        names = [question.name for question in design.spec.questions]
        self._design, self._question = design, names.index(design.spec.plan.balance)
        self.groups = 0
        self._words: dict[str, str] = {}
        self._answers: Counter[str] = Counter()
        self._reasons: Counter[str] = Counter()

    def counts(self, group: Group) -> Counts | None:
        """How often each answer comes in a group; None if a member does not yield the question."""
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
        """The answers of instances without the question, whose answers could not be balanced."""
        came = [f"{words} {self._answers[name]}" for name, words in sorted(self._words.items())]
        lost = [f"rejected {reason} {count}" for reason, count in sorted(self._reasons.items())]
        why = f"{self.groups} draws gave {', '.join([*came, *lost])}: no choice of them has each answer equally often"
        for index, answers in group.items():
            yield index, [self._unbalanced(answer, why) for answer in answers]

    def _unbalanced(self, answer: QuestionRow | Rejected, why: str) -> QuestionRow | Rejected:
        if answer.question != self._question or isinstance(answer, Rejected):
            return answer
        return Rejected(answer.task, answer.index, answer.question, answer.engine, "balance", why)
