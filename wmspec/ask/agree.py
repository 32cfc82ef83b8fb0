"""Whether engines agree: each engine's outcome must pick the same option."""

from __future__ import annotations

from dataclasses import replace

from wmspec.ask.gates import apart
from wmspec.ask.model import Asked, Rejected


def answered(asked: Asked, other: Asked) -> int:
    """Which of `asked`'s options the other engine's outcome picks: the same label, or the nearest picture."""
    if asked.outcome is None or other.outcome is None:
        true = other.options[other.answer].name
        return next(i for i, o in enumerate(asked.options) if o.name == true)
    truth = other.outcome[other.answer]
    gaps = [apart(truth, option) for option in asked.outcome]
    return gaps.index(min(gaps))


def consensus(answers: dict[str, Asked | Rejected]) -> dict[str, Asked | Rejected]:
    """The same question in several engines: kept where all ask it and pick the same option, else rejected in all."""
    first_rejected = next((r for r in answers.values() if isinstance(r, Rejected)), None)
    if first_rejected is not None:
        return {
            engine: answer
            if isinstance(answer, Rejected)
            else Rejected(answer.task, answer.index, answer.question, engine, "disagreement",
                          f"{first_rejected.engine} rejects it: {first_rejected.reason}: {first_rejected.detail}")
            for engine, answer in answers.items()
        }  # fmt: skip
    asked = {e: a for e, a in answers.items() if isinstance(a, Asked)}
    checked: dict[str, Asked | Rejected] = {}
    for engine, mine in asked.items():
        picks = {other: answered(mine, theirs) for other, theirs in asked.items()}
        wrong = [f"{other} picks option {pick}" for other, pick in picks.items() if pick != mine.answer]
        checked[engine] = replace(mine, agreement=tuple(sorted(picks.items())))
        if wrong:
            detail = f"{engine} answers {mine.answer}, {', '.join(wrong)}"
            checked[engine] = Rejected(mine.task, mine.index, mine.question, engine, "disagreement", detail)
    if any(isinstance(c, Rejected) for c in checked.values()):
        reason = "; ".join(c.detail for c in checked.values() if isinstance(c, Rejected))
        return {e: Rejected(a.task, a.index, a.question, e, "disagreement", reason) for e, a in asked.items()}
    return checked
