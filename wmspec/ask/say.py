"""Saying values in words, as a person would."""

from __future__ import annotations

import math
from typing import Any

from wmspec.check.evaluate import Environment, evaluate
from wmspec.check.ir import Question
from wmspec.design.values import Values

#: Which unit a quantity is said in, and how many of it make one SI unit.
_UNITS = {
    "length": ("cm", 100.0),
    "mass": ("g", 1000.0),
    "time": ("s", 1.0),
    "angle": ("°", 180 / math.pi),
    "speed": ("cm/s", 100.0),
    "angular speed": ("°/s", 180 / math.pi),
    "acceleration": ("m/s²", 1.0),
    "plain number": ("", 1.0),
}


def say(value: Any, sort: str, values: Values) -> str:
    """A value of the named kind in words; an object by its colour and shape."""
    if sort == "object":
        return f"the {values.property(value, 'color')} {values.property(value, 'shape')}"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        unit, scale = _UNITS.get(sort, ("", 1.0))
        return f"{value * scale:.4g}{'' if unit.startswith('°') else ' '}{unit}".strip()
    return str(value)


def question_text(question: Question, env: Environment, values: Values) -> str:
    """The text of a question with its values said."""
    parts = (p if isinstance(p, str) else say(evaluate(p.value, env), p.sort, values) for p in question.text)
    return "".join(parts)
