"""Checks `balance`: it needs countable answers and at least one random draw."""

from __future__ import annotations

from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.ir import ir
from wmspec.lang.check.ir.evaluate import subexpressions
from wmspec.lang.check.statements.question_kinds import has_countable_answers


def balance(check: Expressions, spec: ir.TaskSpec) -> None:
    """Report why the answers of the plan's question cannot be balanced, if so."""
    named = next((q for q in spec.questions if q.name and q.name == spec.plan.balance), None)
    design = next(iter(check.scope.designs), None)
    if named is None or design is None:
        return
    span = next(p.value.span for p in design.baseline if p.name.id == "balance")
    message, remedy = _uncountable_reason(named) or _undrawn_reason(spec) or ("", "")
    if message:
        check.report.add("WMS408", message, span, remedy)


def _uncountable_reason(question: ir.Question) -> tuple[str, str] | None:
    if not has_countable_answers(question) or question.options is None:
        what = f"`{question.name}` has no list of answers that could come equally often"
        return what, "balance a question that is answered with one of its `options`, or with yes or no"
    if any(isinstance(part, ir.Ref | ir.Property | ir.Call) for part in subexpressions(question.options)):
        what = f"the options of `{question.name}` differ from instance to instance, so they cannot be counted"
        return what, "list the same for all: `options [0, 1, 2]`"
    return None


def _undrawn_reason(spec: ir.TaskSpec) -> tuple[str, str] | None:
    scattered = any("scatter" in thing.properties for thing in spec.things)
    if scattered or any(factor.nuisance for factor in spec.factors):
        return None
    what = "nothing is drawn here, so a group comes out the same however often it is drawn"
    return what, "let what the answer depends on vary: `nuisance NAME in LOW .. HIGH`"
