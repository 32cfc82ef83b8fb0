"""Keeps groups complete whose members belong together: if one member yields no question, none does.

These are closed sets of options, and groups of possible and impossible episodes. Of the latter, every single picture
must be as often possible as not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from wmspec.compile.design.design import Design
from wmspec.lang.check.ir.ir import Question, TaskSpec
from wmspec.runtime.questions.ask import ask
from wmspec.runtime.questions.model import QuestionRow, Rejected
from wmspec.runtime.questions.picture_balance import balanced_pictures
from wmspec.runtime.questions.runs import EnginePair

#: Results of the questions of an instance.
Answers = Sequence[QuestionRow | Rejected]


def has_closed_set(spec: TaskSpec) -> bool:
    """Whether groups of a task are generated as a whole: for a closed set of options, or for possible episodes."""
    return any(is_whole(spec, question) for question in spec.questions)


def is_whole(spec: TaskSpec, question: Question) -> bool:
    """Whether a question is kept for all members of a group or for none."""
    return bool(question.orbit) or (question.asks_possible and spec.plan.kind == "groups")


def ask_complete(design: Design, index: int, pair: EnginePair) -> Answers:
    """Return every question of an instance, as `ask` does, with closed sets kept complete."""
    if not has_closed_set(design.spec):
        return ask(design, index, pair)
    members = design.blocks.members(design.blocks.locate(index)[0])
    return drop_incomplete_groups(design.spec, {member: ask(design, member, pair) for member in members})[index]


def drop_incomplete_groups(spec: TaskSpec, members: Mapping[int, Answers]) -> dict[int, Answers]:
    """Return the answers of a group by index, without questions of closed sets that lack a member.

    Answers of an instance may come from several engines.
    """
    broken: dict[int, Rejected] = {}
    for answers in members.values():
        for answer in answers:
            if isinstance(answer, Rejected) and is_whole(spec, spec.questions[answer.question]):
                broken.setdefault(answer.question, answer)
    kept = {
        index: [_kept(answer, broken.get(answer.question)) for answer in answers] for index, answers in members.items()
    }
    return balanced_pictures(spec, kept)


def _kept(answer: QuestionRow | Rejected, first: Rejected | None) -> QuestionRow | Rejected:
    if first is None or isinstance(answer, Rejected):
        return answer
    why = f"instance {first.index} in {first.engine}: {first.reason}: {first.detail}"
    return Rejected(answer.task, answer.index, answer.question, answer.engine, "group", why, answer.label)
