"""Answers of each engine, and whether two engines agree."""

from __future__ import annotations

from dataclasses import dataclass

from wmspec.core.diagnostics import WmsError
from wmspec.runtime.questions.ensure_and_margin import smallest_margin
from wmspec.runtime.questions.kinds import KINDS
from wmspec.runtime.questions.model import Answer, Reject
from wmspec.runtime.questions.question_context import QuestionContext, rejection_of


@dataclass(frozen=True)
class EngineAnswer:
    """One engine's `answer` (None without one), its text `words`, and the `measured` values (SI units).

    `rejected` is the gate that the question fails, or None. Gates on pictures are not evaluated.
    """

    answer: Answer | None
    words: str
    measured: dict[str, float]
    rejected: str | None


def answer(asking: QuestionContext) -> EngineAnswer:
    """Return an engine's answer, independent of the gates."""
    kind, measured = KINDS[asking.question.kind], asking.measured
    try:
        value = kind.answer(asking)
        words = kind.words(asking, value)
    except (Reject, WmsError) as error:
        return EngineAnswer(None, "nothing", measured.readings, _reason(error))
    try:
        smallest_margin(asking.question, measured)
        kind.gate(asking, value)
        rejected = None
    except (Reject, WmsError) as error:
        rejected = _reason(error)
    return EngineAnswer(value, words, dict(sorted(measured.readings.items())), rejected)


def agree(a: EngineAnswer, b: EngineAnswer) -> bool:
    """Whether each engine's outcome selects the other's answer, or neither has one."""
    if a.answer is None or b.answer is None:
        return a.answer is b.answer
    return KINDS[a.answer.kind].agree(a.answer, b.answer)


def difference(a: EngineAnswer, b: EngineAnswer, engines: tuple[str, str]) -> str:
    """Return a sentence that compares the answers."""
    if a.answer is not None and b.answer is not None:
        sentence = KINDS[a.answer.kind].compared(a.answer, b.answer, engines)
        if sentence:
            return sentence
    readings = (f"{k} = {a.measured[k]:.4g} and {b.measured.get(k, float('nan')):.4g}" for k in a.measured)
    return "; ".join([f"{engines[0]} answers {a.words}, {engines[1]} {b.words}", *readings])


def _reason(error: Reject | WmsError) -> str:
    reject = error if isinstance(error, Reject) else rejection_of(error)
    return f"{reject.reason}: {reject.detail}"
