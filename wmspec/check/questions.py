"""Checking what is asked: texts, answers, options, gates and counterfactuals."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TypeVar

from wmspec.check import ir
from wmspec.check.expressions import Expressions, Failed, Typed, constant
from wmspec.check.kinds import A_TIME, ACTION, CAMERA, OBJECT, PICTURE, TEXT, TRUTH, Kind, List, Quantity, Word, article
from wmspec.check.things import Things
from wmspec.check.units import NUMBER
from wmspec.check.verbs import VERBS
from wmspec.check.vocabulary import PROPERTIES, Slot
from wmspec.parse import syntax as s
from wmspec.parse.diagnostics import Note
from wmspec.parse.parser import parse_expression
from wmspec.parse.source import Span

T = TypeVar("T")
_HOLE = re.compile(r"\{([^{}]*)\}")


class Questions:
    """Checks questions; a mistake in one clause is reported and the others are still looked at."""

    def __init__(self, check: Expressions, things: Things) -> None:
        self.check = check
        self.scope = check.scope
        self.report = check.report
        self.bounds = things.bounds

    def question(self, question: s.Question) -> ir.Question:
        """A question with all its clauses."""
        text = self.text(question.text)
        by_kind: dict[str, list[s.Clause]] = {}
        for clause in question.clauses:
            by_kind.setdefault(clause.kind, []).append(clause)
            if clause.kind in ("options", "answer", "distinct") and len(by_kind[clause.kind]) > 1:
                notes = (Note("said here first", by_kind[clause.kind][0].span),)
                self.report.add("WMS202", f"`{clause.kind}` is said twice", clause.span, "remove one", notes)
        if "answer" not in by_kind:
            self.check.fail("WMS501", "this question has no answer", question.text.span, "add `answer EXPRESSION`")
        answer, options, sort = self.answer(question, by_kind)
        ensures = [self.tried(lambda c=c: self.ensure(c)) for c in by_kind.get("ensure", [])]  # type: ignore[misc]
        margins = [self.tried(lambda c=c: self.margin(c)) for c in by_kind.get("margin", [])]  # type: ignore[misc]
        changes = [self.tried(lambda c=c: self.counterfactual(c)) for c in question.counterfactuals]  # type: ignore[misc]
        distinct = [self.tried(lambda c=c: self.distinct(c)) for c in by_kind.get("distinct", [])]  # type: ignore[misc]
        return ir.Question(
            text=text,
            sort=sort,
            options=options,
            answer=answer,
            margins=tuple(m for m in margins if m),
            ensures=tuple(e for e in ensures if e),
            distinct=distinct[0] if distinct else None,
            counterfactuals=tuple(c for c in changes if c),
            place=ir.Place.of(question.text.span),
        )

    def tried(self, check: Callable[[], T]) -> T | None:
        """The result of a check, None if it failed."""
        try:
            return check()
        except Failed:
            return None

    def measuring(self, e: s.Expr, wanted: tuple[Kind, ...], what: str) -> Typed:
        """Check an expression in which measured functions may stand."""
        self.check.measured = True
        try:
            return self.check.value(e, wanted, what) if wanted else self.check.infer(e)
        finally:
            self.check.measured = False

    def answer(self, question: s.Question, clauses: dict[str, list[s.Clause]]) -> tuple[ir.Expr, ir.Expr | None, str]:
        """The answer, the options (None for pictures) and the kind of both."""
        clause = clauses["answer"][0]
        answer = self.measuring(clause.value, (), "`answer`")
        if answer.kind == PICTURE:
            if "options" in clauses:
                self.check.fail(
                    "WMS502",
                    "the options of a picture question are its counterfactuals",
                    clauses["options"][0].span,
                    "remove `options`",
                )
            if not question.counterfactuals:
                self.check.fail("WMS502", "a picture question needs counterfactuals to choose from", clause.span,
                                "add `counterfactual NAME { ... }`")  # fmt: skip
            return answer.expr, None, "picture"
        if "options" not in clauses:
            self.check.fail(
                "WMS502",
                f"the answer is {article(str(answer.kind))}, but there are no options",
                clause.span,
                "add `options [...]`",
            )
        if question.counterfactuals:
            span = question.counterfactuals[0].span
            what = "counterfactuals are the options of picture questions"
            self.check.fail("WMS502", what, span, "answer with `frame(CAMERA, TIME)`")
        options = self.check.value(clauses["options"][0].value, (List(answer.kind),), "`options`, like the answer,")
        if not isinstance(options.expr, ir.Items) or len(options.expr.items) < 2:
            self.check.fail("WMS502", "a question has two or more options", clauses["options"][0].value.span)
        return answer.expr, options.expr, str(answer.kind)

    def ensure(self, clause: s.Clause) -> ir.Require:
        """A condition that an instance must meet."""
        typed = self.measuring(clause.value, (TRUTH,), "`ensure`")
        return ir.Require(condition=typed.expr, text=clause.value.span.text, place=ir.Place.of(clause.value.span))

    def margin(self, clause: s.Clause) -> ir.Margin:
        """How far a value must be from turning."""
        assert clause.bound is not None
        value = self.measuring(clause.value, (), "`margin`")
        if not isinstance(value.kind, Quantity):
            self.check.fail(
                "WMS302", f"`margin` wants a quantity, but this is {article(str(value.kind))}", clause.value.span
            )
        bound = self.check.value(clause.bound, (value.kind,), "`apart by`")
        ratio = value.kind.dimension == NUMBER
        if ratio and (factor := constant(bound.expr)) is not None and factor < 1:
            self.check.fail("WMS304", "a ratio is apart by a factor of 1 or more", clause.bound.span)
        return ir.Margin(value=value.expr, bound=bound.expr, ratio=ratio, place=ir.Place.of(clause.span))

    def distinct(self, clause: s.Clause) -> ir.Expr:
        """How far apart options must be."""
        slot = PROPERTIES["object"]["radius"]
        typed = self.check.value(clause.value, slot.kinds, "`distinct by`")
        self.bounds(typed.expr, slot, clause.value.span, "`distinct by`")
        return typed.expr

    def counterfactual(self, counterfactual: s.Counterfactual) -> ir.Counterfactual:
        """A counterfactual: exactly one change."""
        name = counterfactual.name.id
        if len(counterfactual.changes) != 1:
            many = len(counterfactual.changes)
            what = f"a counterfactual changes exactly one thing, but `{name}` changes {many}"
            remedy = "make one counterfactual of each change" if many else "say what would be different"
            self.check.fail("WMS503", what, counterfactual.name.span, remedy)
        change = counterfactual.changes[0]
        where = ir.Place.of(change.span)
        if change.kind == "order":
            self.check.fail(
                "WMS405", "a change of order is not supported yet", change.span, "change the actions' `start`"
            )
        if change.kind == "without":
            target = self.check.value(change.target, (ACTION,), "`without`").expr
            assert isinstance(target, ir.Value)
            return ir.Counterfactual(
                name=name, change="without", owner=str(target.value), property="", value=None, sort="", place=where
            )
        owner, prop, kinds, slot = self.target(change)
        assert change.value is not None
        typed = self.check.value(change.value, kinds, f"`{prop}`")
        self.bounds(typed.expr, slot, change.value.span, f"`{prop}`")
        if typed.expr == ir.Property(owner=ir.Value(value=owner), name=prop):
            self.check.fail("WMS503", "this is what it was before", change.value.span, "change the value")
        assert change.kind in ("action", "state")
        return ir.Counterfactual(
            name=name,
            change=change.kind,
            owner=owner,
            property=prop,
            value=typed.expr,
            sort=str(typed.kind),
            place=where,
        )

    def target(self, change: s.Change) -> tuple[str, str, tuple[Kind, ...], Slot]:
        """What a change is made to: its owner, its name, the kinds it takes and its slot."""
        target = change.target
        example = "push.speed" if change.kind == "action" else "ball.mass"
        if not isinstance(target, s.Member) or not isinstance(target.value, s.Name):
            self.check.fail(
                "WMS503", f"`{change.kind}` changes one named value", target.span, f"write something like `{example}`"
            )
        owner = self.check.infer(target.value)
        is_action = owner.kind == ACTION
        if (
            not isinstance(owner.expr, ir.Value)
            or is_action != (change.kind == "action")
            or owner.kind not in (ACTION, OBJECT, CAMERA)
        ):
            wanted = "an action" if change.kind == "action" else "an object or camera"
            self.check.fail(
                "WMS503",
                f"`{change.kind}` changes {wanted}, but this is {article(str(owner.kind))}",
                target.value.span,
            )
        name, prop = str(owner.expr.value), target.name.id
        if is_action:
            kinds: tuple[Kind, ...] = (self.check.argument_kind(name, target.name),)
            declared = self.scope.names[name]
            assert isinstance(declared, s.Action)
            slot = VERBS[self.check.verb(declared)].arguments.get(prop, Slot((A_TIME,), "", least=0))
        else:
            slot = self.check.slot(PROPERTIES["object" if owner.kind == OBJECT else "camera"], target.name, f"`{name}`")
            kinds = slot.kinds
        return name, prop, kinds, slot

    def text(self, text: s.Text) -> tuple[str | ir.Said, ...]:
        """Split a text at its `{expression}`s and check them."""
        found: list[str | ir.Said] = []
        raw = text.span.text
        end = 1
        for hole in _HOLE.finditer(raw):
            found.append(_unescape(raw[end : hole.start()]))
            end = hole.end()
            span = Span(text.span.source, text.span.start + hole.start(1), text.span.start + hole.end(1))
            expr = parse_expression(span, self.report)
            if expr is None:
                raise Failed
            typed = self.check.infer(expr)
            sort = _sort(typed.kind)
            if sort is None:
                self.check.fail("WMS302", f"{article(str(typed.kind))} cannot be said in a text", span)
            found.append(ir.Said(value=typed.expr, sort=sort))
        found.append(_unescape(raw[end:-1]))
        return tuple(part for part in found if part != "")


def _unescape(text: str) -> str:
    return re.sub(r"\\(.)", lambda m: {"n": "\n", "t": "\t"}.get(m[1], m[1]), text)


def _sort(kind: Kind) -> str | None:
    if isinstance(kind, Word | Quantity) or kind in (OBJECT, TEXT):
        return str(kind)
    return None
