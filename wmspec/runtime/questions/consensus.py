"""Whether engines agree: what each engine's outcome picks of another's options, and which questions are kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

from wmspec.runtime.questions.kinds import KINDS
from wmspec.runtime.questions.model import QuestionRow, Rejected, Vote

#: When a question is kept: if all engines agree on it, if more than half of them do, or whatever they say.
Consensus = Literal["all", "majority", "none"]


def picked(row: QuestionRow, other: QuestionRow) -> int | None:
    """Which of a row's options the other engine's outcome picks; None if it is none of them, or if there are none."""
    name = KINDS[row.kind].picked(row.evidence, other.evidence)
    return next((i for i, option in enumerate(row.options) if option.name == name), None)


def agree(a: QuestionRow, b: QuestionRow) -> bool:
    """Whether each engine's outcome picks the other's answer."""
    return KINDS[a.kind].agree(a.evidence, b.evidence)


def votes(answers: Mapping[str, QuestionRow | Rejected], mine: QuestionRow) -> tuple[Vote, ...]:
    """What every engine says, as picks of my options."""
    return tuple(_vote(engine, answer, mine) for engine, answer in sorted(answers.items()))


def _vote(engine: str, answer: QuestionRow | Rejected, mine: QuestionRow) -> Vote:
    if isinstance(answer, Rejected):
        return Vote(engine, None, "", f"{answer.reason}: {answer.detail}")
    return Vote(engine, picked(mine, answer), answer.value)


def consensus(answers: Mapping[str, QuestionRow | Rejected], wanted: Consensus) -> dict[str, QuestionRow | Rejected]:
    """The same question in several engines, each row with the votes of all; without consensus it is rejected."""
    rows = {engine: answer for engine, answer in answers.items() if isinstance(answer, QuestionRow)}
    judged: dict[str, QuestionRow | Rejected] = {}
    for engine, answer in answers.items():
        if not isinstance(answer, QuestionRow):
            judged[engine] = answer
            continue
        agreeing = sum(agree(answer, other) for other in rows.values())
        if _kept(agreeing, len(answers), wanted):
            judged[engine] = replace(answer, agreement=votes(answers, answer))
        else:
            judged[engine] = _disagreed(answer, answers)
    if wanted == "all" and len(rows) == len(answers) and any(isinstance(a, Rejected) for a in judged.values()):
        return {engine: _disagreed(row, answers) for engine, row in rows.items()}
    return judged


def _kept(agreeing: int, engines: int, wanted: Consensus) -> bool:
    return wanted == "none" or (agreeing == engines if wanted == "all" else 2 * agreeing > engines)


def _disagreed(row: QuestionRow, answers: Mapping[str, QuestionRow | Rejected]) -> Rejected:
    """The question rejected, with what every engine says."""
    detail = "; ".join(_sentence(vote) for vote in votes(answers, row))
    return Rejected(row.task, row.index, row.question, row.engine, "disagreement", detail)


def _sentence(vote: Vote) -> str:
    if vote.rejected:
        return f"{vote.engine} rejects it: {vote.rejected}"
    return f"{vote.engine} answers {vote.value}" if vote.answer is None else f"{vote.engine} picks option {vote.answer}"
