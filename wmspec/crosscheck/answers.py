"""What each engine answers, measured and not drawn: a label, or where everything is in each option's picture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmspec.ask.gates import Reject, apart, distinct, passed
from wmspec.ask.measure import Measured
from wmspec.ask.say import say
from wmspec.check.evaluate import evaluate
from wmspec.check.ir import Question, TaskSpec
from wmspec.crosscheck.model import TRUTH
from wmspec.design.values import Values
from wmspec.scene.model import Scene, Trace


@dataclass(frozen=True)
class Answer:
    """One engine's answer: its `value` as the language has it and `said` in words, what was `measured`, SI units.

    `outcome` holds the poses (n, 7) of the bodies that can move, for the truth and every counterfactual of a picture
    question; None for labels. `rejected` is the gate that it fails, or None.
    """

    value: Any
    said: str
    measured: dict[str, float]
    outcome: dict[str, NDArray[np.float64]] | None
    rejected: str | None


def answer(spec: TaskSpec, question: Question, values: Values, scene: Scene, traces: Mapping[str, Trace]) -> Answer:
    """An engine's answer, from its traces of the truth and of the question's counterfactuals by name."""
    looks = [t for o in spec.observations for t in evaluate(o.times, values)]
    measured = Measured(values, traces[TRUTH], (min(looks), max(looks)))
    value = evaluate(question.answer, measured)
    rejected = None
    outcome = None
    if question.options is None:
        moving = [i for i, b in enumerate(scene.bodies) if b.motion != "static"]
        outcome = {name: _poses(trace, moving, value[1]) for name, trace in traces.items()}
    try:
        passed(question, measured)
        if outcome is not None and question.distinct is not None:
            distinct(np.stack(list(outcome.values())), list(outcome), evaluate(question.distinct, values))
        if question.options is not None and value not in evaluate(question.options, values):
            raise Reject("invalid", f"the answer {say(value, question.sort, values)} is not among the options")
    except Reject as reject:
        rejected = f"{reject.reason}: {reject.detail}"
    said = TRUTH if outcome is not None else say(value, question.sort, values)
    return Answer(value, said, dict(sorted(measured.readings.items())), outcome, rejected)


def _poses(trace: Trace, moving: list[int], time: float) -> NDArray[np.float64]:
    i = trace.sample(time)
    return np.concatenate([trace.position[i, moving], trace.orientation[i, moving]], axis=1)


def picked(mine: Answer, other: Answer) -> str:
    """Which of my options the other engine's outcome picks, in words: the same label, or the nearest picture."""
    if mine.outcome is None or other.outcome is None:
        return other.said
    return min(mine.outcome, key=lambda name: _from(mine, other, name))


def agree(a: Answer, b: Answer) -> bool:
    """Whether each engine's outcome picks the other's answer."""
    if a.outcome is None or b.outcome is None:
        return bool(a.value == b.value)
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
