"""Checks questions: texts, answers, options and gates."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import pi
from typing import TypeVar

from wmspec.core.diagnostics import Note
from wmspec.core.places import Location, Span
from wmspec.lang.check.expressions.bounds import check_bounds
from wmspec.lang.check.expressions.domains import labels, read_domain
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.typed import ZERO, Failed, Typed, common_type, constant
from wmspec.lang.check.ir import ir
from wmspec.lang.check.library.modules import Modules
from wmspec.lang.check.statements.counterfactuals import Counterfactuals
from wmspec.lang.check.statements.factors import Factors
from wmspec.lang.check.statements.objects import Entities
from wmspec.lang.check.statements.orbits import Orbits
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
from wmspec.lang.check.statements.visibility_clauses import visibility
from wmspec.lang.check.tables.vocabulary import LEGIBILITY, PropertySpec
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
#: Values in texts as other languages write them, and what is wrong with them.
_FOREIGN_HOLES = (
    (re.compile(r"\$\{([^{}]*)\}"), "a value in a text has no `$` before it"),
    (re.compile(r"(?<!\\)\{\{([^{}]*)\}\}"), "a value in a text stands in single braces"),
    (re.compile(r"%\((\w+)\)[a-z]"), "a value in a text stands in braces"),
    (
        re.compile(r"(?<!\\)\{([^{}:]*):[^{}:]*\}"),
        "values in texts have no format",
    ),
)
_SINGLE_CLAUSES = ("options", "orbit", "answer", "within", "difference", "stable")
_APART = PropertySpec((A_LENGTH,), "how far apart", above=0)
_TURNED = PropertySpec((AN_ANGLE,), "by what turn", above=0, most=pi)
#: Value of `distinct by` next to quantities: the kind of the outcome.
KIND = "kind"
_YES_NO = ir.Items(items=(ir.Value(value=True), ir.Value(value=False)))


@dataclass(frozen=True)
class DistinctClause:
    """Required difference between options: length (m), angle (rad), and kind of outcome."""

    length: ir.Expr | None = None
    turn: ir.Expr | None = None
    kinds: bool = False


class Questions:
    """Checks questions, once the rest of the task is known (`orbits`).

    An error in one clause is reported and the others are still checked.
    """

    def __init__(self, check: Expressions, modules: Modules, things: Entities, factors: Factors) -> None:
        self.check = check
        self.modules = modules
        self.report = check.report
        self.counterfactuals = Counterfactuals(check, things, factors)
        self.orbits: Orbits
        self._names: dict[str, Span] = {}

    def question(self, question: s.Question) -> ir.Question:
        """Return a question with all its clauses."""
        self._check_unique_name(question)
        text = self.pieces(question.text)
        if all(isinstance(part, str) and not part.strip() for part in text):
            self.check.fail("WMS304", "this question has no text", question.text.span, "write the question")
        clauses: dict[str, list[s.Clause]] = {}
        for clause in question.clauses:
            clauses.setdefault(clause.kind, []).append(clause)
            if clause.kind in _SINGLE_CLAUSES and len(clauses[clause.kind]) > 1:
                notes = (Note("first set here", clauses[clause.kind][0].span),)
                self.report.add("WMS202", f"`{clause.kind}` is set twice", clause.span, "remove one", notes)
        if ANSWER not in clauses:
            self.check.fail("WMS501", "this question has no answer", question.text.span, "add `answer EXPRESSION`")
        kind, options, answer = self._answer(question, clauses)
        margins = self._check_each(self.margin, clauses.get("margin", []))
        ensures = self._check_each(self.ensure, clauses.get("ensure", []))
        changes = [c for made in self._check_each(self.changes, question.counterfactuals) for c in made]
        orbit = self._check_each(self.orbits.orbit, clauses.get(ORBIT, []))
        varied, siblings = orbit[0] if orbit else ((), ())
        self._check_unique_names(changes)
        kinds = [outcome for made in self._check_each(self.kinds, question.kinds) for outcome in made]
        distinct = self._distinct(clauses.get("distinct", []), question.kinds)
        difference = self._check_each(self.difference, clauses.get("difference", []))
        stable = self._check_each(self.separately, clauses.get("stable", []))
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
            legible=self._legible(question.legibility),
            visibility=visibility(self.check, [*clauses.get("hide", []), *clauses.get("seen", [])]),
            film_text=self._model_text("film_text", question),
            action_text=self._model_text("action_text", question),
            counterfactuals=(*changes, *siblings),
            place=Location.of(question.text.span),
        )

    def _check_unique_name(self, question: s.Question) -> None:
        if question.name is None:
            return
        name = question.name
        if name.id in self._names:
            notes = (Note("the first is here", self._names[name.id]),)
            message = f"two questions are named `{name.id}`"
            self.report.add("WMS202", message, name.span, "give one of them another name", notes)
        self._names.setdefault(name.id, name.span)

    def _check_each(self, check: Callable[[C], T], clauses: list[C] | tuple[C, ...]) -> list[T]:
        """Return the results for the clauses without errors."""
        results = []
        for clause in clauses:
            try:
                results.append(check(clause))
            except Failed:
                continue
        return results

    def _model_text(self, kind: str, question: s.Question) -> tuple[str | ir.Interpolation, ...]:
        """Check a text for video models, at most one of a kind, for a picture as the answer."""
        written = [each for each in question.model_texts if each.kind == kind]
        for other in written[1:]:
            notes = (Note("first set here", written[0].span),)
            self.report.add("WMS202", f"`{kind}` is set twice", other.span, "remove one", notes)
        for one in written[:1]:
            if not any(clause.kind == ORBIT for clause in question.clauses):
                message = f"`{kind}` describes a film, and this question has no closed set of films"
                self.report.add("WMS502", message, one.span, "add `options orbit of ...`, or remove it")
            texts = self._check_each(self.pieces, [one.text])
            if texts and "?" in "".join(part for part in texts[0] if isinstance(part, str)):
                what = f"`{kind}` has a question in it; a video model continues a film and answers nothing"
                self.report.add("WMS304", what, one.text.span, "describe the scene in statements")
            return next(iter(texts), ())
        return ()

    def _legible(self, written: tuple[s.Legibility, ...]) -> bool:
        """Check `legibility off`, at most once."""
        for other in written[1:]:
            notes = (Note("first set here", written[0].span),)
            self.report.add("WMS202", "`legibility` is set twice", other.span, "remove one", notes)
        for word in (each.word for each in written if each.word.id not in LEGIBILITY):
            remedy = "remove the line: questions must be legible unless it says `off`" if word.id == "on" else ""
            message = f"`legibility` is `off` or left out, not `{word.id}`"
            self.report.add("WMS201", message, word.span, remedy or "write `legibility off`")
        return not written

    # ------------------------------------------------------------ answers

    def _answer(
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
        if rules.spoken and (several or _spoken_type(answer.type) is None) and answer.type != TRUTH:
            self.check.fail(
                "WMS502", f"{noun} is no answer to a question", clause.value.span, _reduction_hint(answer.type)
            )
        if rule is not None:
            self.check.fail("WMS502", rule.message.format(answer=noun), places[rule.at], rule.remedy)
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

    def _within(self, clauses: dict[str, list[s.Clause]], answer: Typed) -> ir.Expr | None:
        """Return the tolerance of an open answer."""
        if "within" not in clauses:
            return None
        clause = clauses["within"][0]
        typed = self.check.value(clause.value, (answer.type,), "`within`, like the answer,")
        check_bounds(self.check, typed.expr, PropertySpec((answer.type,), "", least=0), clause.value.span, "`within`")
        return typed.expr

    # ------------------------------------------------------------ gates and what is recorded

    def ensure(self, clause: s.Clause) -> ir.Require:
        """Return a condition that an instance must meet."""
        typed = self.check.measuring(clause.value, (TRUTH,), "`ensure`")
        return ir.Require(condition=typed.expr, text=clause.value.span.words, place=Location.of(clause.value.span))

    def margin(self, clause: s.Clause) -> ir.Margin:
        """Return the required distance of a value from the threshold."""
        assert clause.bound is not None
        value, kind = self._quantity(clause, "margin")
        bound = self.check.value(clause.bound, (kind,), "`apart by`")
        ratio = kind.dimension == NUMBER
        if ratio and (factor := constant(bound.expr)) is not None and factor < 1:
            self.check.fail("WMS304", "a ratio is apart by a factor of 1 or more", clause.bound.span)
        check_bounds(self.check, bound.expr, PropertySpec((kind,), "", least=0), clause.bound.span, "`apart by`")
        unless = self.check.measuring(clause.unless, (TRUTH,), "`unless`").expr if clause.unless else None
        return ir.Margin(value=value, bound=bound.expr, ratio=ratio, unless=unless, place=Location.of(clause.span))

    def difference(self, clause: s.Clause) -> ir.Difference:
        """Return the stimulus strength."""
        value, kind = self._quantity(clause, "difference")
        return ir.Difference(value=value, unit=kind.dimension.symbol)

    def _quantity(self, clause: s.Clause, what: str) -> tuple[ir.Expr, Quantity]:
        value = self.check.measuring(clause.value)
        if not isinstance(value.type, Quantity):
            message = f"`{what}` expects a quantity, found {article(str(value.type))}"
            self.check.fail("WMS302", message, clause.value.span)
        return value.expr, Quantity(NUMBER) if value.type.dimension == ZERO else value.type

    def changes(self, written: s.Counterfactual | s.EachOther) -> tuple[ir.Counterfactual, ...]:
        """Return the counterfactuals of a `counterfactual` or `each other` statement."""
        if isinstance(written, s.EachOther):
            return self.orbits.each_other(written)
        return (self.counterfactuals.counterfactual(written),)

    def _check_unique_names(self, changes: list[ir.Counterfactual]) -> None:
        """Report two counterfactuals of one name."""
        first: dict[str, ir.Counterfactual] = {}
        for change in changes:
            if first.setdefault(change.name, change) is not change:
                notes = (Note("the first is here", first[change.name].place),)
                what = f"two counterfactuals of this question are named `{change.name}`"
                self.report.add("WMS202", what, change.place, "give one of them another name", notes)

    def kinds(self, written: s.Kinds) -> tuple[ir.Outcome, ...]:
        """Return the kinds of outcome."""
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

    def _distinct(self, clauses: list[s.Clause], kinds: tuple[s.Kinds, ...]) -> DistinctClause:
        """Check `distinct by 5 cm or 20 deg` and `distinct by kind`: at most one of each."""
        first: dict[bool, s.Clause] = {}
        for clause in clauses:
            kind = self._by_kind(clause)
            if first.setdefault(kind, clause) is not clause:
                notes = (Note("first set here", first[kind].span),)
                self.report.add("WMS202", "`distinct` is set twice", clause.span, "remove one", notes)
        if True in first and not kinds:
            remedy = "define them: `kinds { NAME: CONDITION ... }`"
            self.report.add("WMS502", "the outcomes of this question have no kinds", first[True].value.span, remedy)
        quantities = self._check_each(self.bounds, [first[False]] if False in first else [])
        length, turn = quantities[0] if quantities else (None, None)
        return DistinctClause(length, turn, True in first)

    def _by_kind(self, clause: s.Clause) -> bool:
        return isinstance(clause.value, s.Name) and clause.value.id == KIND and KIND not in self.check.scope.names

    def bounds(self, clause: s.Clause) -> tuple[ir.Expr, ir.Expr | None]:
        """Return the required distance of options and, after `or`, the required angle."""
        length, turn = clause.value, None
        if isinstance(clause.value, s.Operation) and clause.value.operator == "or":
            length, turn = clause.value.operands
        apart = self.separately(replace(clause, value=length))
        if turn is None:
            return apart, None
        typed = self.check.value(turn, _TURNED.types, "`distinct by`, after `or`,")
        check_bounds(self.check, typed.expr, _TURNED, turn.span, "`distinct by`")
        return apart, typed.expr

    def separately(self, clause: s.Clause) -> ir.Expr:
        """Return the required distance of options, or the displacement of objects."""
        typed = self.check.value(clause.value, _APART.types, f"`{clause.kind} by`")
        check_bounds(self.check, typed.expr, _APART, clause.value.span, f"`{clause.kind} by`")
        return typed.expr

    # ------------------------------------------------------------ texts

    def pieces(self, text: s.Pieces) -> tuple[str | ir.Interpolation, ...]:
        """Return the whole text of a question, with its pieces joined."""
        parts: list[str | ir.Interpolation] = []
        for part in (part for piece in text.pieces for part in (" ", *self.text(piece))):
            if isinstance(part, str) and parts and isinstance(parts[-1], str):
                parts[-1] += part
            elif parts or part != " ":
                parts.append(part)
        return tuple(parts)

    def text(self, text: s.Text) -> tuple[str | ir.Interpolation, ...]:
        """Split a text at its `{expression}`s and check these."""
        parts: list[str | ir.Interpolation] = []
        raw = text.span.text
        end = 1
        self._check_foreign_holes(text, raw)
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
            sort = str(TEXT) if self._named(typed.expr) else _spoken_type(typed.type)
            if sort is None:
                self.check.fail("WMS302", f"{article(str(typed.type))} has no wording in a text", span)
            parts.append(ir.Interpolation(value=typed.expr, sort=sort))
        parts.append(_unescape(raw[end:-1]))
        return tuple(part for part in parts if part != "")

    def _check_foreign_holes(self, text: s.Text, raw: str) -> None:
        """Report values in a text that are written as in another language."""
        for pattern, message in _FOREIGN_HOLES:
            if (found := pattern.search(raw)) is not None:
                span = Span(text.span.source, text.span.start + found.start(), text.span.start + found.end())
                self.check.fail("WMS101", message, span, f"write `{{{found[1].strip()}}}`")

    def _texts(self, clauses: dict[str, list[s.Clause]]) -> tuple[ir.TextTemplate, ...]:
        """Return the texts with inserted values among options and answers."""
        written = [clause.value for kind in ("options", ANSWER) for clause in clauses.get(kind, [])]
        holes = {text.value: text for text in s.texts(tuple(written)) if _BRACE.search(text.span.text)}
        return tuple(ir.TextTemplate(text=value, parts=self.text(text)) for value, text in holes.items())

    def _named(self, expr: ir.Expr) -> bool:
        """Whether an expression is a factor or nuisance with labelled values."""
        factor = self.check.scope.names.get(expr.name) if isinstance(expr, ir.Ref) else None
        return isinstance(factor, s.Factor) and labels(read_domain(self.check, factor.domain)) is not None


def _reduction_hint(of: Type) -> str:
    """Return how to reduce several values to one answer, for messages, or ''."""
    if of == List(TRUTH):
        return "write `count(...)`, `any(...)` or `all(...)` of it"
    if isinstance(of, List) and isinstance(of.item, Quantity):
        return "write `sum(...)`, `min(...)` or `max(...)` of it"
    return "ask for one of its parts: `.x`, `.y`" if isinstance(of, Vector) else ""


def _unescape(text: str) -> str:
    return re.sub(r"\\(.)", lambda m: {"n": "\n", "t": "\t"}.get(m[1], m[1]), text)


def _spoken_type(of: Type) -> str | None:
    """Return the name of a type whose values have a wording, or None."""
    if of == Quantity(ZERO):
        return str(Quantity(NUMBER))
    if isinstance(of, List):
        return str(of) if of.item is not None and _spoken_type(of.item) else None
    return str(of) if isinstance(of, Word | Quantity | Vector) or of in (OBJECT, TEXT, LABEL) else None
