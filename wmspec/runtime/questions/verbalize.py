"""Saying values in words, as a person would."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any

from wmspec.compile.layout.values import Values
from wmspec.lang.check.ir import ir
from wmspec.lang.check.ir.evaluate import Environment, evaluate
from wmspec.lang.check.tables.vocabulary import WORDS
from wmspec.lang.check.types import units
from wmspec.runtime.questions.bearing import Bearing
from wmspec.runtime.questions.referring_expressions import color_word, described, together

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
_SI = {
    str(d): d.symbol
    for d in (
        *(units.NUMBER, units.LENGTH, units.MASS, units.TIME, units.ANGLE, units.SPEED, units.ACCELERATION),
        *(units.ANGULAR_SPEED, units.DENSITY, units.FORCE, units.IMPULSE, units.VOLUME, units.LENGTH**2),
        units.NUMBER / units.TIME,
    )
}
#: How the kinds of points, sizes and directions begin.
_TUPLES = ("pair of", "triple of")
#: Relations in a text, where what they relate to follows.
_RELATIONS = {"left_of": "to the left of", "right_of": "to the right of", "in_front_of": "in front of"}

_ENDS_IN_THE = re.compile(r"\bthe $", re.IGNORECASE)


def say(value: Any, sort: str, values: Values) -> str:
    """A value of the named kind in words; an object by what tells it from the others.

    Raises Ambiguous for an object that words cannot tell from another.
    """
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        unit, scale = _UNITS.get(sort, (si_unit(sort), 1.0)) if sort != "mass" or abs(value) < 1 else ("kg", 1.0)
        number = f"{value * scale + 0.0:.4g}"  # -0.0 + 0.0 is 0.0
        if isinstance(value, Bearing) and number == "-180":
            number = "180"
        return f"{number}{'' if unit.startswith('°') else ' '}{unit}".strip()
    if isinstance(value, tuple):
        objects = {t.name for t in values.spec.things if t.kind == "object"}
        if value and objects.issuperset(value) and (words := together(value, values)):
            return words
        said = [say(v, _of_each(sort), values) for v in value]
        return f"({', '.join(said)})" if sort.startswith(_TUPLES) else listed(said)
    if sort in ("object", "label") and any(t.name == value and t.kind == "object" for t in values.spec.things):
        return described(value, values)
    if sort == "color":
        return color_word(value)
    if sort == "text" or (sort == "label" and value not in WORDS["tie"]):
        return str(value)
    return _RELATIONS.get(value, str(value).replace("_", " "))


def _of_each(sort: str) -> str:
    """The kind of each item of a list or a tuple: of `list of objects`, `object`; of `pair of lengths`, `length`."""
    several = sort.partition(" of ")[2] or sort
    if several.startswith(("pairs", "triples")):
        return several.replace("s", "", 1)
    if several.startswith("values ("):
        return several[len("values (") : -1]
    return several.removesuffix("s")


def say_option(value: Any, sort: str, values: Values) -> str:
    """A value in words that stand alone."""
    words = say(value, sort, values)
    return f"{words} it" if sort == "relation" else words


def listed(words: Sequence[str]) -> str:
    """`a, b and c`."""
    return " and ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else "".join(words)


def si_unit(sort: str) -> str:
    """The SI unit of a kind of quantity; empty for plain numbers."""
    return _SI.get(sort, sort)


def question_text(question: ir.Question, env: Environment, values: Values) -> str:
    """The text of a question with its values said."""
    return filled(question.text, env, values)


def filled(parts: Sequence[str | ir.Said], env: Environment, values: Values) -> str:
    """A text with its values said; an article before an object, which has its own, is the text's."""
    text = ""
    for part in parts:
        words = part if isinstance(part, str) else _spoken(part, env, values)
        if not isinstance(part, str) and _ENDS_IN_THE.search(text):
            words = words.removeprefix("the ")
        text += words
    return text


def _spoken(part: ir.Said, env: Environment, values: Values) -> str:
    """A value of a text in words: what it is called, if it is that of a factor whose values have names."""
    value = evaluate(part.value, env)
    factor = next((f for f in values.spec.factors if part.value == ir.Ref(name=f.name)), None)
    called = factor.called(value) if factor is not None else None
    return say(value, part.sort, values) if called is None else called


def written(expr: ir.Expr) -> str:
    """An expression as one would write it, numbers in SI units."""
    match expr:
        case ir.Value():
            return _constant(expr.value)
        case ir.Ref():
            return expr.name
        case ir.Property():
            return f"{written(expr.owner)}.{expr.name}"
        case ir.Items():
            return f"[{', '.join(map(written, expr.items))}]"
        case ir.Call(function="present", arguments=(ir.Items(items=(ir.Value(value=str(first)), *_)),)):
            return first.rpartition("_")[0]  # a set, by its own name
        case ir.Call(function="nth", arguments=(items, ir.Value(value=float(number)))):
            return f"{written(items)}[{number:g}]"
        case ir.Call():
            options = (f"{option.name}: {written(option.value)}" for option in expr.options)
            return f"{expr.function}({', '.join([*map(written, expr.arguments), *options])})"
        case ir.Operation():
            return _operation(expr.operator, [_operand(o) for o in expr.operands])


def _operation(operator: str, operands: list[str]) -> str:
    if operator == "if":
        return "if {} then {} else {}".format(*operands)
    return f" {operator} ".join(operands) if len(operands) > 1 else f"{operator} {operands[0]}"


def _operand(expr: ir.Expr) -> str:
    return f"({written(expr)})" if isinstance(expr, ir.Operation) else written(expr)


def _constant(value: bool | float | str) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return value if isinstance(value, str) else f"{value:g}"
