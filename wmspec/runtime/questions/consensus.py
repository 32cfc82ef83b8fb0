"""Agreement of engines: the option that each engine's outcome selects, and which questions are kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import combinations
from typing import Literal

from wmspec.lang.check.ir.ir import QuestionKind
from wmspec.runtime.questions.kinds import KINDS
from wmspec.runtime.questions.model import Measurement, QuestionRow, Rejected, Vote

#: Keep a question if all engines agree, if the majority agrees, or always.
Consensus = Literal["all", "majority", "none"]

#: A row is a question, or a question in one of the engines.
RowsOf = Literal["questions", "engines"]

#: The answer of an engine, with or without pictures.
Valid = QuestionRow | Measurement
#: What an engine answers, or why it rejects the question.
Answered = QuestionRow | Measurement | Rejected
#: The largest distance (m) of a body between an engine and the engine of the row, by engine.
Distances = Mapping[str, float]


def picked_option(row: QuestionRow, other: Valid) -> int | None:
    """Return the option of a row that the outcome of another engine selects; None if there is none."""
    name = KINDS[row.kind].picked(row.evidence, other.evidence)
    return next((i for i, option in enumerate(row.options) if option.name == name), None)


def agree(a: Valid, b: Valid) -> bool:
    """Whether the outcome of each engine selects the answer of the other."""
    return KINDS[a.evidence.kind].agree(a.evidence, b.evidence)


def votes(answers: Mapping[str, Answered], mine: QuestionRow, apart: Distances) -> tuple[Vote, ...]:
    """Return the answer of every engine as an option of `mine`."""
    return tuple(_vote(engine, answer, mine, apart.get(engine)) for engine, answer in sorted(answers.items()))


def _vote(engine: str, answer: Answered, mine: QuestionRow, apart: float | None) -> Vote:
    if isinstance(answer, Rejected):
        return Vote(engine, None, "", f"{answer.reason}: {answer.detail}", apart)
    return Vote(engine, picked_option(mine, answer), answer.value, None, apart)


def consensus(
    answers: Mapping[str, QuestionRow | Rejected],
    required: Consensus,
    apart: Mapping[str, Distances] | None = None,
) -> dict[str, QuestionRow | Rejected]:
    """Return the question in several engines, each row with all votes, or rejected without consensus."""
    return {
        engine: judge(answer, answers, required, (apart or {}).get(engine, {}))
        if isinstance(answer, QuestionRow)
        else answer
        for engine, answer in answers.items()
    }


def judge(
    row: QuestionRow, answers: Mapping[str, Answered], required: Consensus, apart: Distances
) -> QuestionRow | Rejected:
    """Return a row with the votes of all engines, itself included, or rejected without consensus."""
    if _is_kept(row, answers, required):
        return replace(row, agreement=votes(answers, row, apart))
    detail = "; ".join(_sentence(vote, row.kind) for vote in votes(answers, row, apart))
    return Rejected(row.task, row.index, row.question, row.engine, "disagreement", detail, row.label)


def _is_kept(row: QuestionRow, answers: Mapping[str, Answered], required: Consensus) -> bool:
    valid = [answer for answer in answers.values() if not isinstance(answer, Rejected)]
    if required == "all":
        return len(valid) == len(answers) and all(agree(a, b) for a, b in combinations(valid, 2))
    return required == "none" or 2 * sum(agree(row, other) for other in valid) > len(answers)


def _sentence(vote: Vote, kind: QuestionKind) -> str:
    if vote.rejected:
        return f"{vote.engine} rejects it: {vote.rejected}"
    return f"{vote.engine} {KINDS[kind].vote_words(vote.value, vote.answer)}"
