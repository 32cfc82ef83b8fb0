"""Whether engines agree: what each engine's outcome picks of another's options, and which questions are kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

from wmspec.ask.gates import apart
from wmspec.ask.model import QuestionRow, Rejected, Vote

#: When a question is kept: if all engines agree on it, if more than half of them do, or whatever they say.
Consensus = Literal["all", "majority", "none"]


def answered(asked: QuestionRow, other: QuestionRow) -> int | None:
    """Which of `asked`'s options the other engine's outcome picks: the same label, or the nearest picture.

    None if it is none of them, and for open questions, which have no options.
    """
    if asked.outcome is None or other.outcome is None:
        true = other.options[other.answer].name if other.answer is not None else None
        return next((i for i, o in enumerate(asked.options) if o.name == true), None)
    assert other.answer is not None
    truth = other.outcome[other.answer]
    gaps = [apart(truth, option) for option in asked.outcome]
    return gaps.index(min(gaps))


def agree(a: QuestionRow, b: QuestionRow) -> bool:
    """Whether each engine's outcome picks the other's answer; open numbers may differ by what is allowed."""
    if a.number is not None and b.number is not None and a.number.within is not None:
        return abs(a.number.value - b.number.value) <= a.number.within
    return answered(a, b) == a.answer and answered(b, a) == b.answer


def votes(answers: Mapping[str, QuestionRow | Rejected], mine: QuestionRow | None) -> tuple[Vote, ...]:
    """What every engine says, as picks of `mine`'s options."""
    return tuple(_vote(engine, answer, mine) for engine, answer in sorted(answers.items()))


def _vote(engine: str, answer: QuestionRow | Rejected, mine: QuestionRow | None) -> Vote:
    if isinstance(answer, Rejected):
        return Vote(engine, None, "", f"{answer.reason}: {answer.detail}")
    return Vote(engine, answered(mine, answer) if mine is not None else None, answer.value)


def consensus(answers: Mapping[str, QuestionRow | Rejected], wanted: Consensus) -> dict[str, QuestionRow | Rejected]:
    """The same question in several engines, each told what the others say; without consensus it is rejected."""
    asked = {e: a for e, a in answers.items() if isinstance(a, QuestionRow)}
    told: dict[str, QuestionRow | Rejected] = {}
    for engine, answer in answers.items():
        if not isinstance(answer, QuestionRow):
            told[engine] = answer
            continue
        agreeing = sum(agree(answer, other) for other in asked.values())
        if _kept(agreeing, len(answers), wanted):
            told[engine] = replace(answer, agreement=votes(answers, answer))
        else:
            told[engine] = _disagreed(answer, answers)
    if wanted == "all" and len(asked) == len(answers) and any(isinstance(a, Rejected) for a in told.values()):
        return {engine: _disagreed(answer, answers) for engine, answer in asked.items()}
    return told


def _kept(agreeing: int, engines: int, wanted: Consensus) -> bool:
    return wanted == "none" or (agreeing == engines if wanted == "all" else 2 * agreeing > engines)


def _disagreed(answer: QuestionRow, answers: Mapping[str, QuestionRow | Rejected]) -> Rejected:
    """The question rejected, with what every engine says."""
    said = []
    for vote in votes(answers, answer):
        if vote.rejected:
            said.append(f"{vote.engine} rejects it: {vote.rejected}")
        elif vote.answer is None:
            said.append(f"{vote.engine} answers {vote.value}")
        else:
            said.append(f"{vote.engine} picks option {vote.answer}")
    detail = "; ".join(said)
    return Rejected(answer.task, answer.index, answer.question, answer.engine, "disagreement", detail)
