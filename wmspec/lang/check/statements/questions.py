"""Checks questions, clause by clause."""

from __future__ import annotations

from wmspec.core.diagnostics import Note
from wmspec.core.places import Location, Span
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.typed import without_failed
from wmspec.lang.check.ir import ir
from wmspec.lang.check.library.modules import Modules
from wmspec.lang.check.statements.counterfactuals import Counterfactuals
from wmspec.lang.check.statements.factors import Factors
from wmspec.lang.check.statements.objects import Entities
from wmspec.lang.check.statements.orbits import Orbits
from wmspec.lang.check.statements.question_answers import QuestionAnswers
from wmspec.lang.check.statements.question_gates import QuestionGates
from wmspec.lang.check.statements.question_kinds import ANSWER, ORBIT
from wmspec.lang.check.statements.question_texts import QuestionTexts
from wmspec.lang.check.statements.visibility_clauses import visibility
from wmspec.lang.check.tables.vocabulary import LEGIBILITY
from wmspec.lang.check.types.types import TRUTH
from wmspec.lang.parse import syntax as s

_SINGLE_CLAUSES = ("options", "orbit", "answer", "within", "difference", "stable")


class Questions:
    """Checks questions, once the rest of the task is known (`orbits`).

    An error in one clause is reported and the others are still checked.
    """

    def __init__(self, check: Expressions, modules: Modules, things: Entities, factors: Factors) -> None:
        self.check = check
        self.report = check.report
        self.texts = QuestionTexts(check, modules)
        self.answers = QuestionAnswers(check)
        self.gates = QuestionGates(check)
        self.counterfactuals = Counterfactuals(check, things, factors)
        self.orbits: Orbits
        self._names: dict[str, Span] = {}

    def question(self, question: s.Question) -> ir.Question:
        """Return a question with all its clauses."""
        self._check_unique_name(question)
        text = self.texts.pieces(question.text)
        if all(isinstance(part, str) and not part.strip() for part in text):
            self.check.fail("WMS304", "this question has no text", question.text.span, "write the question")
        clauses: dict[str, list[s.Clause]] = {}
        for clause in question.clauses:
            clauses.setdefault(clause.kind, []).append(clause)
        self.report.add_set_twice((c.kind, c.span) for c in question.clauses if c.kind in _SINGLE_CLAUSES)
        if ANSWER not in clauses:
            self.check.fail("WMS501", "this question has no answer", question.text.span, "add `answer EXPRESSION`")
        kind, options, answer = self.answers.answer(question, clauses)
        margins = without_failed(self.gates.margin, clauses.get("margin", []))
        ensures = without_failed(self.gates.ensure, clauses.get("ensure", []))
        changes = [c for made in without_failed(self.changes, question.counterfactuals) for c in made]
        orbit = without_failed(self.orbits.orbit, clauses.get(ORBIT, []))
        varied, siblings = orbit[0] if orbit else ((), ())
        named = ((change.name, change.place) for change in changes)
        message = "two counterfactuals of this question are named `{}`"
        self.report.add_repeated(named, message, note="the first is here")
        kinds = [outcome for made in without_failed(self.kinds, question.kinds) for outcome in made]
        apart, turn, by_kind = self.gates.distinct(clauses.get("distinct", []), question.kinds)
        difference = without_failed(self.gates.difference, clauses.get("difference", []))
        stable = without_failed(self.gates.separately, clauses.get("stable", []))
        return ir.Question(
            name=question.name.id if question.name else "",
            text=text,
            kind=kind,
            sort=str(answer.type),
            options=options,
            answer=answer.expr,
            margins=tuple(margins),
            ensures=tuple(ensures),
            distinct=apart,
            distinct_turn=turn,
            distinct_kinds=by_kind,
            texts=self.texts.templates(clauses),
            kinds=tuple(kinds),
            orbit=varied,
            within=self.answers.within(clauses, answer),
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

    def _model_text(self, kind: str, question: s.Question) -> tuple[str | ir.Interpolation, ...]:
        """Check a text for video models, at most one of a kind, for a picture as the answer."""
        written = [each for each in question.model_texts if each.kind == kind]
        self.report.add_set_twice((kind, each.span) for each in written)
        for one in written[:1]:
            if not any(clause.kind == ORBIT for clause in question.clauses):
                message = f"`{kind}` describes a film, and this question has no closed set of films"
                self.report.add("WMS502", message, one.span, "add `options orbit of ...`, or remove it")
            texts = without_failed(self.texts.pieces, [one.text])
            if texts and "?" in "".join(part for part in texts[0] if isinstance(part, str)):
                what = f"`{kind}` has a question in it; a video model continues a film and answers nothing"
                self.report.add("WMS304", what, one.text.span, "describe the scene in statements")
            return next(iter(texts), ())
        return ()

    def _legible(self, written: tuple[s.Legibility, ...]) -> bool:
        """Check `legibility off`, at most once."""
        self.report.add_set_twice(("legibility", each.span) for each in written)
        for word in (each.word for each in written if each.word.id not in LEGIBILITY):
            remedy = "remove the line: questions must be legible unless it says `off`" if word.id == "on" else ""
            message = f"`legibility` is `off` or left out, not `{word.id}`"
            self.report.add("WMS201", message, word.span, remedy or "write `legibility off`")
        return not written

    def changes(self, written: s.Counterfactual | s.EachOther) -> tuple[ir.Counterfactual, ...]:
        """Return the counterfactuals of a `counterfactual` or `each other` statement."""
        if isinstance(written, s.EachOther):
            return self.orbits.each_other(written)
        return (self.counterfactuals.counterfactual(written),)

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
