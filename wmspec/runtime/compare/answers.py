"""What each engine answers, as the question's kind answers it, and whether two engines answer the same."""

from __future__ import annotations

from dataclasses import dataclass

from wmspec.core.diagnostics import WmsError
from wmspec.runtime.questions.gates import passed
from wmspec.runtime.questions.kinds import KINDS
from wmspec.runtime.questions.model import Answer, Reject
from wmspec.runtime.questions.question_context import Asking, refused


@dataclass(frozen=True)
class EngineAnswer:
    """One engine's `answer` (None if it has none), the same in `words`, and what was `measured` (SI units).

    `rejected` is the gate that the question fails, or None. What only pictures show is not looked at.
    """

    answer: Answer | None
    words: str
    measured: dict[str, float]
    rejected: str | None


def answer(asking: Asking) -> EngineAnswer:
    """An engine's answer, whatever the gates say."""
    kind, measured = KINDS[asking.question.kind], asking.measured
    try:
        value = kind.answer(asking)
        words = kind.words(asking, value)
    except (Reject, WmsError) as error:
        return EngineAnswer(None, "nothing", measured.readings, _reason(error))
    try:
        passed(asking.question, measured)
        kind.gate(asking, value)
        rejected = None
    except (Reject, WmsError) as error:
        rejected = _reason(error)
    return EngineAnswer(value, words, dict(sorted(measured.readings.items())), rejected)


def agree(a: EngineAnswer, b: EngineAnswer) -> bool:
    """Whether each engine's outcome picks the other's answer, or neither has one."""
    if a.answer is None or b.answer is None:
        return a.answer is b.answer
    return KINDS[a.answer.kind].agree(a.answer, b.answer)


def difference(a: EngineAnswer, b: EngineAnswer, engines: tuple[str, str]) -> str:
    """How the answers compare, in a sentence for a person."""
    if a.answer is not None and b.answer is not None:
        sentence = KINDS[a.answer.kind].compared(a.answer, b.answer, engines)
        if sentence:
            return sentence
    readings = (f"{k} = {a.measured[k]:.4g} and {b.measured.get(k, float('nan')):.4g}" for k in a.measured)
    return "; ".join([f"{engines[0]} answers {a.words}, {engines[1]} {b.words}", *readings])


def _reason(error: Reject | WmsError) -> str:
    reject = error if isinstance(error, Reject) else refused(error)
    return f"{reject.reason}: {reject.detail}"
