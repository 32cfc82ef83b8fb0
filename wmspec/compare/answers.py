"""What each engine answers, measured and not drawn: a label, or where everything is in each option's picture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmspec.ask.ask import said_answer
from wmspec.ask.describe import Ambiguous
from wmspec.ask.gates import apart, distinct, passed
from wmspec.ask.measure import Measured
from wmspec.ask.model import Reject
from wmspec.ask.options import same
from wmspec.ask.runs import EnginePair, Run
from wmspec.ask.views import looked
from wmspec.check.evaluate import evaluate
from wmspec.check.ir import Question
from wmspec.compare.model import TRUTH
from wmspec.diagnostics import WmsError


@dataclass(frozen=True)
class Answer:
    """One engine's answer: its `value` as the language has it and `said` in words, what was `measured`, SI units.

    `outcome` holds the poses (n, 7) of the bodies that can move, for the truth and every counterfactual of a picture
    question; None for labels. `rejected` is the gate that it fails, or None. `within` is how far apart the numbers that
    an open question asks for may be.
    """

    value: Any
    said: str
    measured: dict[str, float]
    outcome: dict[str, NDArray[np.float64]] | None
    rejected: str | None
    within: float | None = None


def answer(question: Question, runs: Mapping[str, Run], crew: EnginePair) -> Answer:
    """An engine's answer, from its runs of the truth and of the question's counterfactuals by name."""
    truth = runs[TRUTH]
    measured = Measured(truth.values, truth.observed(looked(truth.values.spec, truth.values), crew))
    try:
        value = evaluate(question.answer, measured)
        said = TRUTH if question.sort == "picture" else said_answer(question, value, truth.values)
        outcome = _outcome(runs, value[1]) if question.sort == "picture" else None
    except WmsError as error:
        reason = "alike" if isinstance(error, Ambiguous) else "invalid"
        return Answer(None, "nothing", measured.readings, None, f"{reason}: {error}")
    rejected = _rejected(question, value, measured, outcome)
    within = None if question.within is None else evaluate(question.within, truth.values)
    return Answer(value, said, dict(sorted(measured.readings.items())), outcome, rejected, within)


def _outcome(runs: Mapping[str, Run], time: float) -> dict[str, NDArray[np.float64]]:
    """Where the bodies that can move are in each run's picture. Raises WmsError if that is taken after its end."""
    names = list(dict.fromkeys(name for run in runs.values() for name in run.movable()))
    return {name: run.poses(names, time) for name, run in runs.items()}


def _rejected(
    question: Question, value: Any, measured: Measured, outcome: dict[str, NDArray[np.float64]] | None
) -> str | None:
    """The gate that the question fails, or None."""
    try:
        passed(question, measured)
        if outcome is not None and question.distinct is not None:
            distinct(np.stack(list(outcome.values())), list(outcome), evaluate(question.distinct, measured.values))
        if question.options is not None and not any(same(value, o) for o in evaluate(question.options, measured)):
            raise Reject(
                "invalid", f"the answer {said_answer(question, value, measured.values)} is not among the options"
            )
    except Reject as reject:
        return f"{reject.reason}: {reject.detail}"
    except WmsError as error:
        return f"invalid: {error}"
    return None


def picked(mine: Answer, other: Answer) -> str:
    """Which of my options the other engine's outcome picks, in words: the same label, or the nearest picture."""
    if mine.outcome is None or other.outcome is None:
        return other.said
    return min(mine.outcome, key=lambda name: _from(mine, other, name))


def agree(a: Answer, b: Answer) -> bool:
    """Whether each engine's outcome picks the other's answer."""
    if a.outcome is None or b.outcome is None:
        near = a.within is not None and None not in (a.value, b.value) and abs(a.value - b.value) <= a.within
        return near or same(a.value, b.value)
    return picked(a, b) == picked(b, a) == TRUTH


def told(a: Answer, b: Answer, engines: tuple[str, str]) -> str:
    """How the answers compare, in a sentence for a person."""
    if a.outcome is None or b.outcome is None:
        readings = (f"{k} = {a.measured[k]:.4g} and {b.measured.get(k, float('nan')):.4g}" for k in a.measured)
        return "; ".join([f"{engines[0]} answers {a.said}, {engines[1]} {b.said}", *readings])
    said = []
    for mine, other, names in ((a, b, engines), (b, a, engines[::-1])):
        pick = picked(mine, other)
        if pick != TRUTH:
            said.append(
                f"what happens in {names[1]} is {_from(mine, other, pick) * 100:.1f} cm from `{pick}` "
                f"but {_from(mine, other, TRUTH) * 100:.1f} cm from the truth in {names[0]}"
            )
    return "; ".join(said) or f"the outcomes are {_from(a, b, TRUTH) * 100:.1f} cm apart"


def _from(mine: Answer, other: Answer, name: str) -> float:
    assert mine.outcome is not None
    assert other.outcome is not None
    return apart(other.outcome[TRUTH], mine.outcome[name])
