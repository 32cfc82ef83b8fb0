"""Checking what `balance` asks for: answers that can be counted, and something that is drawn anew."""

from __future__ import annotations

from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.ir import ir
from wmspec.lang.check.ir.evaluate import parts
from wmspec.lang.check.statements.question_kinds import counted


def balance(check: Expressions, spec: ir.TaskSpec) -> None:
    """Report why the answers of the question that the plan names cannot be balanced, if they cannot."""
    named = next((q for q in spec.questions if q.name and q.name == spec.plan.balance), None)
    design = next(iter(check.scope.designs), None)
    if named is None or design is None:
        return
    span = next(p.value.span for p in design.baseline if p.name.id == "balance")
    message, remedy = _unfit(named) or _undrawn(spec) or ("", "")
    if message:
        check.report.add("WMS408", message, span, remedy)


def _unfit(question: ir.Question) -> tuple[str, str] | None:
    if not counted(question) or question.options is None:
        what = f"`{question.name}` has no list of answers that could come equally often"
        return what, "balance a question that is answered with one of its `options`, or with yes or no"
    if any(isinstance(part, ir.Ref | ir.Property | ir.Call) for part in parts(question.options)):
        what = f"the options of `{question.name}` differ from instance to instance, so they cannot be counted"
        return what, "list the same for all: `options [0, 1, 2]`"
    return None


def _undrawn(spec: ir.TaskSpec) -> tuple[str, str] | None:
    scattered = any("scatter" in thing.properties for thing in spec.things)
    if scattered or any(factor.nuisance for factor in spec.factors):
        return None
    what = "nothing is drawn here, so a group comes out the same however often it is drawn"
    return what, "let what the answer depends on vary: `nuisance NAME in LOW .. HIGH`"
