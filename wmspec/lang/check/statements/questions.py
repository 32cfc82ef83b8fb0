"""Checking what is asked: texts, answers, options and gates."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import pi
from typing import TypeVar

from wmspec.core.diagnostics import Note
from wmspec.core.places import Location, Span
from wmspec.lang.check.expressions.bounds import within
from wmspec.lang.check.expressions.domains import names, read
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.typed import ZERO, Failed, Typed, constant, joined
from wmspec.lang.check.ir import ir
from wmspec.lang.check.library.modules import Modules
from wmspec.lang.check.statements.counterfactuals import Counterfactuals
from wmspec.lang.check.statements.objects import Things
from wmspec.lang.check.statements.orbits import Orbits
from wmspec.lang.check.statements.question_kinds import (
    ANSWER,
    COUNTERFACTUAL,
    ORBIT,
    QUESTION_RULES,
    broken,
    question_kind,
)
from wmspec.lang.check.tables.vocabulary import Slot
from wmspec.lang.check.types.types import (
    A_LENGTH,
    AN_ANGLE,
    LABEL,
    OBJECT,
    PICTURE,
    TEXT,
    TRUTH,
    List,
    Quantity,
    Type,
    Vector,
    Word,
    article,
)
from wmspec.lang.check.types.units import NUMBER
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.parser import parse_expression

T = TypeVar("T")
C = TypeVar("C")
_HOLE = re.compile(r"(?<!\\)\{([^{}]*)\}")
_BRACE = re.compile(r"(?<!\\)[{}]")
_ONCE = ("options", "orbit", "answer", "within", "difference", "stable")
_APART = Slot((A_LENGTH,), "how far apart", above=0)
_TURNED = Slot((AN_ANGLE,), "by what turn", above=0, most=pi)
#: What `distinct by` takes beside quantities: the kind of the outcome.
KIND = "kind"
_YES_NO = ir.Items(items=(ir.Value(value=True), ir.Value(value=False)))


@dataclass(frozen=True)
class Distinct:
    """How options must differ: by so much (m), or by such a turn (rad), and in kind."""

    length: ir.Expr | None = None
    turn: ir.Expr | None = None
    kinds: bool = False


class Questions:
    """Checks questions, once the rest of the task is known (`orbits`).

    A mistake in one clause is reported and the others are still looked at.
    """

    def __init__(self, check: Expressions, modules: Modules, things: Things) -> None:
        self.check = check
        self.modules = modules
        self.report = check.report
        self.counterfactuals = Counterfactuals(check, things)
        self.orbits: Orbits
        self._names: dict[str, Span] = {}

    def question(self, question: s.Question) -> ir.Question:
        """A question with all its clauses."""
        self._named_once(question)
        text = self.pieces(question.text)
        if all(isinstance(part, str) and not part.strip() for part in text):
            self.check.fail("WMS304", "this question asks nothing", question.text.span, "say what is asked")
        clauses: dict[str, list[s.Clause]] = {}
        for clause in question.clauses:
            clauses.setdefault(clause.kind, []).append(clause)
            if clause.kind in _ONCE and len(clauses[clause.kind]) > 1:
                notes = (Note("said here first", clauses[clause.kind][0].span),)
                self.report.add("WMS202", f"`{clause.kind}` is said twice", clause.span, "remove one", notes)
        if ANSWER not in clauses:
            self.check.fail("WMS501", "this question has no answer", question.text.span, "add `answer EXPRESSION`")
        kind, options, answer = self._answer(question, clauses)
        margins = self._tried(self.margin, clauses.get("margin", []))
        ensures = self._tried(self.ensure, clauses.get("ensure", []))
        changes = [c for made in self._tried(self.changes, question.counterfactuals) for c in made]
        orbit = self._tried(self.orbits.orbit, clauses.get(ORBIT, []))
        varied, siblings = orbit[0] if orbit else ((), ())
        self._unlike(changes)
        kinds = [outcome for made in self._tried(self.kinds, question.kinds) for outcome in made]
        distinct = self._distinct(clauses.get("distinct", []), question.kinds)
        difference = self._tried(self.difference, clauses.get("difference", []))
        stable = self._tried(self.apart, clauses.get("stable", []))
        return ir.Question(
            name=question.name.id if question.name else "",
            text=text,
            kind=kind,
            sort=str(answer.type),
            options=options,
            answer=answer.expr,
            margins=tuple(margins),
            ensures=tuple(ensures),
            distinct=distinct.length,
            distinct_turn=distinct.turn,
            distinct_kinds=distinct.kinds,
            texts=self._texts(clauses),
            kinds=tuple(kinds),
            orbit=varied,
            within=self._within(clauses, answer),
            difference=next(iter(difference), None),
            stable=next(iter(stable), None),
            counterfactuals=(*changes, *siblings),
            place=Location.of(question.text.span),
        )

    def _named_once(self, question: s.Question) -> None:
        if question.name is None:
            return
        name = question.name
        if name.id in self._names:
            notes = (Note("the first is here", self._names[name.id]),)
            message = f"two questions are named `{name.id}`"
            self.report.add("WMS202", message, name.span, "give one of them another name", notes)
        self._names.setdefault(name.id, name.span)

    def _tried(self, check: Callable[[C], T], clauses: list[C] | tuple[C, ...]) -> list[T]:
        """What became of clauses, without those that have mistakes."""
        results = []
        for clause in clauses:
            try:
                results.append(check(clause))
            except Failed:
                continue
        return results

    # ------------------------------------------------------------ answers

    def _answer(
        self, question: s.Question, clauses: dict[str, list[s.Clause]]
    ) -> tuple[ir.QuestionKind, ir.Expr | None, Typed]:
        """The kind of the question, its options in words (None if it has none) and its answer."""
        clause = clauses[ANSWER][0]
        answer = self.check.measuring(clause.value)
        if answer.type == Quantity(ZERO):
            answer = Typed(answer.expr, Quantity(NUMBER))
        places = {kind: written[0].span for kind, written in clauses.items()}
        if question.kinds:
            places["kinds"] = question.kinds[0].span
        if question.counterfactuals:
            places[COUNTERFACTUAL] = question.counterfactuals[0].span
            if ORBIT in places and answer.type == PICTURE:
                what = "a closed set has no options but the siblings, and this adds one"
                self.check.fail("WMS508", what, places[COUNTERFACTUAL], "remove it, or the orbit")
        elif ORBIT in places and answer.type == PICTURE:
            places[COUNTERFACTUAL] = places[ORBIT]  # the siblings
        kind = question_kind(answer.type, places.keys())
        rules = QUESTION_RULES[kind]
        noun = article(str(answer.type))
        rule = broken(rules, answer.type, places.keys())
        several = isinstance(answer.type, List | Vector)
        if rules.spoken and (several or _spoken(answer.type) is None) and answer.type != TRUTH:
            self.check.fail("WMS502", f"{noun} is no answer to a question", clause.value.span, _made_one(answer.type))
        if rule is not None:
            self.check.fail("WMS502", rule.message.format(answer=noun), places[rule.at], rule.remedy)
        if "options" in clauses:
            return kind, *self._options(clauses["options"][0], answer)
        return kind, _YES_NO if answer.type == TRUTH else None, answer

    def _options(self, clause: s.Clause, answer: Typed) -> tuple[ir.Expr, Typed]:
        """The options, and the answer as one of their common kind."""
        options = self.check.infer(clause.value, (List(answer.type), List(LABEL)))
        common = joined(options.type, List(answer.type))
        if not isinstance(common, List) or common.item is None:
            self.check.misfit(clause.value, options.type, (List(answer.type),), "`options`, like the answer,")
        if isinstance(options.expr, ir.Items) and len(options.expr.items) < 2:
            self.check.fail("WMS502", "a question has two or more options", clause.value.span)
        self._once_each(clause.value, options.expr)
        return options.expr, Typed(answer.expr, common.item)

    def _once_each(self, written: s.Expr, options: ir.Expr) -> None:
        """Complain about an option that is written twice."""
        if not isinstance(written, s.Items) or not isinstance(options, ir.Items):
            return
        first: dict[ir.Expr, s.Expr] = {}
        for item, option in zip(written.items, options.items, strict=True):
            if isinstance(option, ir.Value) and (other := first.setdefault(option, item)) is not item:
                notes = (Note("it is here first", other.span),)
                self.check.fail(
                    "WMS507", f"the option `{item.span.text}` is here twice", item.span, "remove one", notes
                )

    def _within(self, clauses: dict[str, list[s.Clause]], answer: Typed) -> ir.Expr | None:
        """How far an open answer may be off."""
        if "within" not in clauses:
            return None
        clause = clauses["within"][0]
        typed = self.check.value(clause.value, (answer.type,), "`within`, like the answer,")
        within(self.check, typed.expr, Slot((answer.type,), "", least=0), clause.value.span, "`within`")
        return typed.expr

    # ------------------------------------------------------------ gates and what is recorded

    def ensure(self, clause: s.Clause) -> ir.Require:
        """A condition that an instance must meet."""
        typed = self.check.measuring(clause.value, (TRUTH,), "`ensure`")
        return ir.Require(condition=typed.expr, text=clause.value.span.words, place=Location.of(clause.value.span))

    def margin(self, clause: s.Clause) -> ir.Margin:
        """How far a value must be from turning."""
        assert clause.bound is not None
        value, kind = self._quantity(clause, "margin")
        bound = self.check.value(clause.bound, (kind,), "`apart by`")
        ratio = kind.dimension == NUMBER
        if ratio and (factor := constant(bound.expr)) is not None and factor < 1:
            self.check.fail("WMS304", "a ratio is apart by a factor of 1 or more", clause.bound.span)
        within(self.check, bound.expr, Slot((kind,), "", least=0), clause.bound.span, "`apart by`")
        unless = self.check.measuring(clause.unless, (TRUTH,), "`unless`").expr if clause.unless else None
        return ir.Margin(value=value, bound=bound.expr, ratio=ratio, unless=unless, place=Location.of(clause.span))

    def difference(self, clause: s.Clause) -> ir.Difference:
        """How strong the stimulus is."""
        value, kind = self._quantity(clause, "difference")
        return ir.Difference(value=value, unit=kind.dimension.symbol)

    def _quantity(self, clause: s.Clause, what: str) -> tuple[ir.Expr, Quantity]:
        value = self.check.measuring(clause.value)
        if not isinstance(value.type, Quantity):
            message = f"`{what}` wants a quantity, but this is {article(str(value.type))}"
            self.check.fail("WMS302", message, clause.value.span)
        return value.expr, Quantity(NUMBER) if value.type.dimension == ZERO else value.type

    def changes(self, written: s.Counterfactual | s.EachOther) -> tuple[ir.Counterfactual, ...]:
        """What a counterfactual, or one of each other level, stands for."""
        if isinstance(written, s.EachOther):
            return self.orbits.each_other(written)
        return (self.counterfactuals.counterfactual(written),)

    def _unlike(self, changes: list[ir.Counterfactual]) -> None:
        """Complain about two counterfactuals of one name."""
        first: dict[str, ir.Counterfactual] = {}
        for change in changes:
            if first.setdefault(change.name, change) is not change:
                notes = (Note("the first is here", first[change.name].place),)
                what = f"two counterfactuals of this question are named `{change.name}`"
                self.report.add("WMS202", what, change.place, "give one of them another name", notes)

    def kinds(self, written: s.Kinds) -> tuple[ir.Outcome, ...]:
        """The kinds of outcome."""
        outcomes: dict[str, ir.Outcome] = {}
        for p in written.kinds:
            name, span = p.name.id, p.value.span
            if p.at is not None:
                self.check.fail("WMS101", "`at` has no meaning here", p.at.span, "write one condition")
            if name in outcomes:
                self.check.fail("WMS202", f"two kinds are named `{name}`", p.name.span, "put them in one, with `or`")
            typed = self.check.measuring(p.value, (TRUTH,), f"`{name}`")
            outcomes[name] = ir.Outcome(
                name=name, condition=typed.expr, text=span.words, place=Location.of(p.name.span.to(span))
            )
        if not outcomes:
            self.check.fail("WMS502", "there are no kinds here", written.span, "write `kinds { NAME: CONDITION ... }`")
        return tuple(outcomes.values())

    def _distinct(self, clauses: list[s.Clause], kinds: tuple[s.Kinds, ...]) -> Distinct:
        """`distinct by 5 cm or 20 deg`, and `distinct by kind`: at most one of each."""
        first: dict[bool, s.Clause] = {}
        for clause in clauses:
            kind = self._by_kind(clause)
            if first.setdefault(kind, clause) is not clause:
                notes = (Note("said here first", first[kind].span),)
                self.report.add("WMS202", "`distinct` is said twice", clause.span, "remove one", notes)
        if True in first and not kinds:
            remedy = "say which there are: `kinds { NAME: CONDITION ... }`"
            self.report.add("WMS502", "the outcomes of this question have no kinds", first[True].value.span, remedy)
        quantities = self._tried(self.bounds, [first[False]] if False in first else [])
        length, turn = quantities[0] if quantities else (None, None)
        return Distinct(length, turn, True in first)

    def _by_kind(self, clause: s.Clause) -> bool:
        return isinstance(clause.value, s.Name) and clause.value.id == KIND and KIND not in self.check.scope.names

    def bounds(self, clause: s.Clause) -> tuple[ir.Expr, ir.Expr | None]:
        """How far apart options must be, `or` how much they must be turned."""
        length, turn = clause.value, None
        if isinstance(clause.value, s.Operation) and clause.value.operator == "or":
            length, turn = clause.value.operands
        apart = self.apart(replace(clause, value=length))
        if turn is None:
            return apart, None
        typed = self.check.value(turn, _TURNED.types, "`distinct by`, after `or`,")
        within(self.check, typed.expr, _TURNED, turn.span, "`distinct by`")
        return apart, typed.expr

    def apart(self, clause: s.Clause) -> ir.Expr:
        """How far apart options must be, or how far objects are nudged."""
        typed = self.check.value(clause.value, _APART.types, f"`{clause.kind} by`")
        within(self.check, typed.expr, _APART, clause.value.span, f"`{clause.kind} by`")
        return typed.expr

    # ------------------------------------------------------------ texts

    def pieces(self, text: s.Pieces) -> tuple[str | ir.Said, ...]:
        """The whole text of a question, as if it had been written in one piece."""
        parts: list[str | ir.Said] = []
        for part in (part for piece in text.pieces for part in (" ", *self.text(piece))):
            if isinstance(part, str) and parts and isinstance(parts[-1], str):
                parts[-1] += part
            elif parts or part != " ":
                parts.append(part)
        return tuple(parts)

    def text(self, text: s.Text) -> tuple[str | ir.Said, ...]:
        """Split a text at its `{expression}`s and check them."""
        parts: list[str | ir.Said] = []
        raw = text.span.text
        end = 1
        for brace in _BRACE.finditer(_HOLE.sub(lambda hole: " " * len(hole[0]), raw)):
            at = text.span.start + brace.start()
            remedy = "write `{EXPRESSION}` for a value, or `\\{` and `\\}` for braces"
            what = "closed" if brace[0] == "{" else "opened"
            self.check.fail("WMS101", f"this brace is never {what}", Span(text.span.source, at, at + 1), remedy)
        for hole in _HOLE.finditer(raw):
            parts.append(_unescape(raw[end : hole.start()]))
            end = hole.end()
            span = Span(text.span.source, text.span.start + hole.start(1), text.span.start + hole.end(1))
            expr = parse_expression(span, self.report)
            if expr is None:
                raise Failed
            typed = self.check.infer(self.modules.plain(expr))
            sort = str(TEXT) if self._named(typed.expr) else _spoken(typed.type)
            if sort is None:
                self.check.fail("WMS302", f"{article(str(typed.type))} cannot be said in a text", span)
            parts.append(ir.Said(value=typed.expr, sort=sort))
        parts.append(_unescape(raw[end:-1]))
        return tuple(part for part in parts if part != "")

    def _texts(self, clauses: dict[str, list[s.Clause]]) -> tuple[ir.Filled, ...]:
        """The texts of options and answers that say values."""
        written = [clause.value for kind in ("options", ANSWER) for clause in clauses.get(kind, [])]
        holes = {text.value: text for text in s.texts(tuple(written)) if _BRACE.search(text.span.text)}
        return tuple(ir.Filled(text=value, parts=self.text(text)) for value, text in holes.items())

    def _named(self, expr: ir.Expr) -> bool:
        """Whether it is a factor or nuisance whose values have names."""
        factor = self.check.scope.names.get(expr.name) if isinstance(expr, ir.Ref) else None
        return isinstance(factor, s.Factor) and names(read(self.check, factor.domain)) is not None


def _made_one(of: Type) -> str:
    """How several values become one that can be an answer; empty if there is no short way to say it."""
    if of == List(TRUTH):
        return "write `count(...)`, `any(...)` or `all(...)` of it"
    if isinstance(of, List) and isinstance(of.item, Quantity):
        return "write `sum(...)`, `min(...)` or `max(...)` of it"
    return "ask for one of its parts: `.x`, `.y`" if isinstance(of, Vector) else ""


def _unescape(text: str) -> str:
    return re.sub(r"\\(.)", lambda m: {"n": "\n", "t": "\t"}.get(m[1], m[1]), text)


def _spoken(of: Type) -> str | None:
    """The type of a value that can be said in words, as it is named; None if it cannot."""
    if of == Quantity(ZERO):
        return str(Quantity(NUMBER))
    if isinstance(of, List):
        return str(of) if of.item is not None and _spoken(of.item) else None
    return str(of) if isinstance(of, Word | Quantity | Vector) or of in (OBJECT, TEXT, LABEL) else None
