"""Values in words."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.lang.check.ir import ir
from wmspec.lang.check.ir.evaluate import Environment, evaluate
from wmspec.lang.check.tables.vocabulary import WORDS
from wmspec.lang.check.types import units
from wmspec.runtime.questions.bearing import Bearing
from wmspec.runtime.questions.referring_expressions import color_word, group_expression, referring_expression

#: Display unit per quantity, and its factor from SI.
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
#: Prefixes of tuple types.
_TUPLES = ("pair of", "triple of")
#: Relations in a text, before their object.
_RELATIONS = {"left_of": "to the left of", "right_of": "to the right of", "in_front_of": "in front of"}

_ENDS_IN_THE = re.compile(r"\bthe $", re.IGNORECASE)


def verbalize(value: Any, sort: str, values: Evaluator) -> str:
    """Return a value of a type in words; an object by a referring expression.

    Raises Ambiguous for an object that words cannot distinguish.
    """
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        unit, scale = _UNITS.get(sort, (si_unit(sort), 1.0)) if sort != "mass" or abs(value) < 1 else ("kg", 1.0)
        number = f"{value * scale + 0.0:.4g}"  # turns -0.0 into 0.0
        if isinstance(value, Bearing) and number == "-180":
            number = "180"
        return f"{number}{'' if unit.startswith('°') else ' '}{unit}".strip()
    if isinstance(value, tuple):
        objects = {t.name for t in values.spec.things if t.kind == "object"}
        if value and objects.issuperset(value) and (words := group_expression(value, values)):
            return words
        said = [verbalize(v, _of_each(sort), values) for v in value]
        return f"({', '.join(said)})" if sort.startswith(_TUPLES) else join_words(said)
    if sort in ("object", "label") and any(t.name == value and t.kind == "object" for t in values.spec.things):
        return referring_expression(value, values)
    if sort == "color":
        return color_word(value)
    if sort == "text" or (sort == "label" and value not in WORDS["tie"]):
        return str(value)
    return _RELATIONS.get(value, str(value).replace("_", " "))


def _of_each(sort: str) -> str:
    """Return the item type of a list or tuple type: `object` of `list of objects`, `length` of `pair of lengths`."""
    several = sort.partition(" of ")[2] or sort
    if several.startswith(("pairs", "triples")):
        return several.replace("s", "", 1)
    if several.startswith("values ("):
        return several[len("values (") : -1]
    return several.removesuffix("s")


def verbalize_option(value: Any, sort: str, values: Evaluator) -> str:
    """Return a value in words that stand alone."""
    words = verbalize(value, sort, values)
    return f"{words} it" if sort == "relation" else words


def join_words(words: Sequence[str]) -> str:
    """Return `a, b and c`."""
    return " and ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else "".join(words)


def si_unit(sort: str) -> str:
    """Return the SI unit of a type of quantity; '' for plain numbers."""
    return _SI.get(sort, sort)


def question_text(question: ir.Question, env: Environment, values: Evaluator) -> str:
    """Return the text of a question with its values."""
    return fill_template(question.text, env, values)


def fill_template(parts: Sequence[str | ir.Interpolation], env: Environment, values: Evaluator) -> str:
    """Return a text with its values; an article in the text replaces that of an object."""
    text = ""
    for part in parts:
        words = part if isinstance(part, str) else _interpolated(part, env, values)
        if not isinstance(part, str) and _ENDS_IN_THE.search(text):
            words = words.removeprefix("the ")
        text += words
    return text


def _interpolated(part: ir.Interpolation, env: Environment, values: Evaluator) -> str:
    """Return an interpolated value in words, by its name if the factor names its values."""
    value = evaluate(part.value, env)
    factor = next((f for f in values.spec.factors if part.value == ir.Ref(name=f.name)), None)
    called = factor.called(value) if factor is not None else None
    return verbalize(value, part.sort, values) if called is None else called


def format_expression(expr: ir.Expr) -> str:
    """Return an expression in source form, with numbers in SI units."""
    match expr:
        case ir.Value():
            return _constant(expr.value)
        case ir.Ref():
            return expr.name
        case ir.Property():
            return f"{format_expression(expr.owner)}.{expr.name}"
        case ir.Items():
            return f"[{', '.join(map(format_expression, expr.items))}]"
        case ir.Call():
            return _call(expr)
        case ir.Operation():
            return _operation(expr.operator, [_operand(o) for o in expr.operands])
        case ir.WhatIf() | ir.Cause():
            return _imagined(expr)


def _call(expr: ir.Call) -> str:
    """Return a call in source form; sets, their members and headings are calls only in the IR."""
    match expr.function, expr.arguments:
        case "present", (ir.Items(items=(ir.Value(value=str(first)), *_)),):
            return first.rpartition("_")[0]  # a set by its name
        case "nth", (items, ir.Value(value=float(index))):
            return f"{format_expression(items)}[{index:g}]"
        case "member", (ir.Items(items=(first, *_)), number):
            return f"{format_expression(first).rpartition('_')[0]}[{format_expression(number)}]"
        case "heading_of", (direction,):
            return format_expression(direction)
    options = (f"{option.name}: {format_expression(option.value)}" for option in expr.options)
    return f"{expr.function}({', '.join([*map(format_expression, expr.arguments), *options])})"


def _imagined(expr: ir.WhatIf | ir.Cause) -> str:
    if isinstance(expr, ir.WhatIf):
        return f"{format_expression(expr.value)} under {expr.change.name}"
    return f"cause of {format_expression(expr.condition)} among {format_expression(expr.candidates)}"


def _operation(operator: str, operands: list[str]) -> str:
    if operator == "if":
        return "if {} then {} else {}".format(*operands)
    return f" {operator} ".join(operands) if len(operands) > 1 else f"{operator} {operands[0]}"


def _operand(expr: ir.Expr) -> str:
    return f"({format_expression(expr)})" if isinstance(expr, ir.Operation) else format_expression(expr)


def _constant(value: bool | float | str) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return value if isinstance(value, str) else f"{value:g}"
