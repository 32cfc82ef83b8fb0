"""Agreement of engines: the option that each engine's outcome selects, and which questions are kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

from wmspec.runtime.questions.kinds import KINDS
from wmspec.runtime.questions.model import QuestionRow, Rejected, Vote

#: Keep a question if all engines agree, if the majority agrees, or always.
Consensus = Literal["all", "majority", "none"]


def picked_option(row: QuestionRow, other: QuestionRow) -> int | None:
    """Return the option of a row that the outcome of another engine selects; None if there is none."""
    name = KINDS[row.kind].picked(row.evidence, other.evidence)
    return next((i for i, option in enumerate(row.options) if option.name == name), None)


def agree(a: QuestionRow, b: QuestionRow) -> bool:
    """Whether the outcome of each engine selects the answer of the other."""
    return KINDS[a.kind].agree(a.evidence, b.evidence)


def votes(answers: Mapping[str, QuestionRow | Rejected], mine: QuestionRow) -> tuple[Vote, ...]:
    """Return the answer of every engine as an option of `mine`."""
    return tuple(_vote(engine, answer, mine) for engine, answer in sorted(answers.items()))


def _vote(engine: str, answer: QuestionRow | Rejected, mine: QuestionRow) -> Vote:
    if isinstance(answer, Rejected):
        return Vote(engine, None, "", f"{answer.reason}: {answer.detail}")
    return Vote(engine, picked_option(mine, answer), answer.value)


def consensus(answers: Mapping[str, QuestionRow | Rejected], required: Consensus) -> dict[str, QuestionRow | Rejected]:
    """Return the question in several engines, each row with all votes, or rejected without consensus."""
    rows = {engine: answer for engine, answer in answers.items() if isinstance(answer, QuestionRow)}
    judged: dict[str, QuestionRow | Rejected] = {}
    for engine, answer in answers.items():
        if not isinstance(answer, QuestionRow):
            judged[engine] = answer
            continue
        agreeing = sum(agree(answer, other) for other in rows.values())
        if _is_kept(agreeing, len(answers), required):
            judged[engine] = replace(answer, agreement=votes(answers, answer))
        else:
            judged[engine] = _disagreement(answer, answers)
    if required == "all" and len(rows) == len(answers) and any(isinstance(a, Rejected) for a in judged.values()):
        return {engine: _disagreement(row, answers) for engine, row in rows.items()}
    return judged


def _is_kept(agreeing: int, engines: int, required: Consensus) -> bool:
    return required == "none" or (agreeing == engines if required == "all" else 2 * agreeing > engines)


def _disagreement(row: QuestionRow, answers: Mapping[str, QuestionRow | Rejected]) -> Rejected:
    """Return the rejected question with the answers of all engines."""
    detail = "; ".join(_sentence(vote) for vote in votes(answers, row))
    return Rejected(row.task, row.index, row.question, row.engine, "disagreement", detail, row.label)


def _sentence(vote: Vote) -> str:
    if vote.rejected:
        return f"{vote.engine} rejects it: {vote.rejected}"
    return f"{vote.engine} answers {vote.value}" if vote.answer is None else f"{vote.engine} picks option {vote.answer}"
