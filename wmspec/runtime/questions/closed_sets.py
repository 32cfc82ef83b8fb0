"""Closed sets of options stay closed: where one member of a group yields no question, none of them does."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from wmspec.compile.design.design import Design
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.runtime.questions.ask import ask
from wmspec.runtime.questions.model import QuestionRow, Rejected
from wmspec.runtime.questions.runs import EnginePair

#: What comes of the questions of an instance.
Answers = Sequence[QuestionRow | Rejected]


def has_closed(spec: TaskSpec) -> bool:
    """Whether a task has a question whose options are a closed set, so that its groups are made as a whole."""
    return any(question.orbit for question in spec.questions)


def ask_whole(design: Design, index: int, pair: EnginePair) -> Answers:
    """Every question of an instance, as `ask` does, where closed sets are kept closed."""
    if not has_closed(design.spec):
        return ask(design, index, pair)
    members = design.blocks.members(design.blocks.locate(index)[0])
    return kept_whole(design.spec, {member: ask(design, member, pair) for member in members})[index]


def kept_whole(spec: TaskSpec, members: Mapping[int, Answers]) -> dict[int, Answers]:
    """The answers of a group's members, by index, without the questions of closed sets that lack a member.

    An instance's answers may be those of several engines.
    """
    broken: dict[int, Rejected] = {}
    for answers in members.values():
        for answer in answers:
            if isinstance(answer, Rejected) and spec.questions[answer.question].orbit:
                broken.setdefault(answer.question, answer)
    return {
        index: [_kept(answer, broken.get(answer.question)) for answer in answers] for index, answers in members.items()
    }


def _kept(answer: QuestionRow | Rejected, first: Rejected | None) -> QuestionRow | Rejected:
    if first is None or isinstance(answer, Rejected):
        return answer
    why = f"instance {first.index} in {first.engine}: {first.reason}: {first.detail}"
    return Rejected(answer.task, answer.index, answer.question, answer.engine, "group", why)
