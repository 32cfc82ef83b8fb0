"""Checks answers of questions, with their options and tolerance."""

from __future__ import annotations

from wmspec.core.diagnostics import Note
from wmspec.core.places import Span
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.typed import ZERO, Typed, common_type
from wmspec.lang.check.ir import ir
from wmspec.lang.check.statements.overlapping_options import warn_overlapping
from wmspec.lang.check.statements.possibility import (
    POSSIBLE_ANSWER,
    POSSIBLE_OPTIONS,
    is_possibility,
    require_violation,
)
from wmspec.lang.check.statements.question_kinds import (
    ANSWER,
    COUNTERFACTUAL,
    ORBIT,
    QUESTION_RULES,
    question_kind,
    violated_rule,
)
from wmspec.lang.check.statements.question_texts import spoken_type
from wmspec.lang.check.tables.vocabulary import PropertySpec
from wmspec.lang.check.types.types import LABEL, PICTURE, TEXT, TRUTH, List, Quantity, Type, Vector, article
from wmspec.lang.check.types.units import NUMBER
from wmspec.lang.parse import syntax as s

_YES_NO = ir.Items(items=(ir.Value(value=True), ir.Value(value=False)))


class QuestionAnswers:
    """Checks answers; an error is reported and raises `Failed`."""

    def __init__(self, check: Expressions) -> None:
        self.check = check
        self.report = check.report

    def answer(
        self, question: s.Question, clauses: dict[str, list[s.Clause]]
    ) -> tuple[ir.QuestionKind, ir.Expr | None, Typed]:
        """Return the kind of the question, its options in words (or None) and its answer."""
        clause = clauses[ANSWER][0]
        possible = is_possibility(self.check, clause.value)
        answer = POSSIBLE_ANSWER if possible else self.check.measuring(clause.value)
        if answer.type == Quantity(ZERO):
            answer = Typed(answer.expr, Quantity(NUMBER))
        places = self._places(question, clauses, answer)
        kind = question_kind(answer.type, places.keys())
        rules = QUESTION_RULES[kind]
        noun = article(str(answer.type))
        rule = violated_rule(rules, answer.type, places.keys())
        several = isinstance(answer.type, List | Vector)
        if rules.spoken and (several or spoken_type(answer.type) is None) and answer.type != TRUTH:
            self.check.fail(
                "WMS502", f"{noun} is no answer to a question", clause.value.span, _reduction_hint(answer.type)
            )
        if rule is not None:
            self.check.fail("WMS502", rule.message.format(answer=noun), places[rule.at or rule.clause], rule.remedy)
        if possible:
            require_violation(self.check, clause.value)
            return kind, POSSIBLE_OPTIONS, Typed(answer.expr, TEXT)
        if "options" in clauses:
            return kind, *self._options(clauses["options"][0], answer)
        return kind, _YES_NO if answer.type == TRUTH else None, answer

    def _places(self, question: s.Question, clauses: dict[str, list[s.Clause]], answer: Typed) -> dict[str, Span]:
        """Return where each kind of clause is, pseudo-clauses included."""
        places = {kind: written[0].span for kind, written in clauses.items()}
        if question.kinds:
            places["kinds"] = question.kinds[0].span
        if question.counterfactuals:
            places[COUNTERFACTUAL] = question.counterfactuals[0].span
            if ORBIT in places and answer.type == PICTURE:
                what = "a closed set has no options but the siblings, and this adds one"
                self.check.fail("WMS508", what, places[COUNTERFACTUAL], "remove it, or the orbit")
        elif ORBIT in places and answer.type == PICTURE:
            places[COUNTERFACTUAL] = places[ORBIT]  # orbits are counterfactuals too
        if isinstance(answer.expr, ir.WhatIf) and answer.type == PICTURE:
            self._check_picture_under(question, places)
        return places

    def _check_picture_under(self, question: s.Question, places: dict[str, Span]) -> None:
        """Report a what-if whose options are siblings, and a counterfactual with the name of the actual outcome."""
        for written in question.counterfactuals:
            if isinstance(written, s.Counterfactual) and written.name.id == ir.ACTUAL:
                message = f"`{ir.ACTUAL}` is the option that shows the episode as it is"
                self.check.fail("WMS202", message, written.name.span, "give the counterfactual another name")
        if ORBIT in places:
            message = "the options of this question are siblings in a group, and its answer is a what-if"
            self.check.fail("WMS508", message, places[ORBIT], "write `counterfactual`s, or remove them")
        places.setdefault(COUNTERFACTUAL, places[ANSWER])  # the actual outcome is an option

    def _options(self, clause: s.Clause, answer: Typed) -> tuple[ir.Expr, Typed]:
        """Return the options, and the answer converted to their common type."""
        options = self.check.infer(clause.value, (List(answer.type), List(LABEL)))
        common = common_type(options.type, List(answer.type))
        if not isinstance(common, List) or common.item is None:
            self.check.type_mismatch(clause.value, options.type, (List(answer.type),), "`options`, like the answer,")
        if isinstance(options.expr, ir.Items) and len(options.expr.items) < 2:
            self.check.fail("WMS502", "a question has two or more options", clause.value.span)
        self._check_unique_options(clause.value, options.expr)
        warn_overlapping(clause.value, self.check.scope, self.report)
        return options.expr, Typed(answer.expr, common.item)

    def _check_unique_options(self, written: s.Expr, options: ir.Expr) -> None:
        """Report a duplicate option."""
        if not isinstance(written, s.Items) or not isinstance(options, ir.Items):
            return
        first: dict[ir.Expr, s.Expr] = {}
        for item, option in zip(written.items, options.items, strict=True):
            if isinstance(option, ir.Value) and (other := first.setdefault(option, item)) is not item:
                notes = (Note("it is here first", other.span),)
                self.check.fail(
                    "WMS507", f"the option `{item.span.text}` is here twice", item.span, "remove one", notes
                )

    def within(self, clauses: dict[str, list[s.Clause]], answer: Typed) -> ir.Expr | None:
        """Return the tolerance of an open answer."""
        if "within" not in clauses:
            return None
        clause = clauses["within"][0]
        typed = self.check.value(clause.value, (answer.type,), "`within`, like the answer,")
        self.check.bounds(typed.expr, PropertySpec((answer.type,), "", least=0), clause.value.span, "`within`")
        return typed.expr


def _reduction_hint(of: Type) -> str:
    """Return how to reduce several values to one answer, for messages, or ''."""
    if of == List(TRUTH):
        return "write `count(...)`, `any(...)` or `all(...)` of it"
    if isinstance(of, List) and isinstance(of.item, Quantity):
        return "write `sum(...)`, `min(...)` or `max(...)` of it"
    return "ask for one of its parts: `.x`, `.y`" if isinstance(of, Vector) else ""
