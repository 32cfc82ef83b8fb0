"""Creates the questions of an instance in one engine: executes, gates, measures the answer, draws the options."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TypeVar

from wmspec.compile.design.about import referenced_objects
from wmspec.compile.design.design import Design, Instance
from wmspec.compile.design.what_ifs import imagines
from wmspec.core.diagnostics import GraphicsError, WmsError
from wmspec.core.rng import Permutation, bits
from wmspec.lang.check.expressions.measured import CHANGE, PREDICTED, is_measured, moments
from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.lang.check.ir.ir import Channel, Level, TaskSpec
from wmspec.runtime.questions.answer_label import answer_label, member_label
from wmspec.runtime.questions.changes import change_of
from wmspec.runtime.questions.declared_visibility import visible_parts
from wmspec.runtime.questions.ensure_and_margin import smallest_margin
from wmspec.runtime.questions.kinds import KINDS
from wmspec.runtime.questions.legibility import legibility, require_legible
from wmspec.runtime.questions.model import (
    Answer,
    Change,
    Measurement,
    Picture,
    QuestionRow,
    Reject,
    Rejected,
    Strength,
    VisibleObject,
    VisiblePart,
)
from wmspec.runtime.questions.question_context import (
    AnswerSlot,
    ClosedSlot,
    QuestionContext,
    ShuffledSlot,
    rejection_of,
)
from wmspec.runtime.questions.robustness import require_stable
from wmspec.runtime.questions.runs import EnginePair, Run, execute
from wmspec.runtime.questions.verbalize import fill_template, format_expression, question_text
from wmspec.runtime.questions.views import View, channels_of
from wmspec.runtime.questions.visibility_gate import connected_sets, require_visible, require_visible_in
from wmspec.runtime.questions.visible_object import visible_objects

T = TypeVar("T")


def ask(design: Design, index: int, pair: EnginePair) -> list[QuestionRow | Rejected]:
    """Return every question of an instance, as a row or rejected with its reason."""
    instance = design[index]
    numbers = range(len(design.spec.questions))
    try:
        run = execute(design, instance, None, pair)
    except Reject as reject:
        return [rejected(design, instance, q, pair, reject) for q in numbers]
    return [question_row(design, instance, q, run, pair) for q in numbers]


def question_row(design: Design, instance: Instance, q: int, run: Run, pair: EnginePair) -> QuestionRow | Rejected:
    """Return one question of an executed instance."""
    asking = _context(design, q, run, pair)
    made = _caught(lambda: _Row(design, instance, q, asking).row())
    if isinstance(made, Reject):
        return rejected(design, instance, q, pair, made, asking)
    return made


def measurement(design: Design, instance: Instance, q: int, run: Run, pair: EnginePair) -> Measurement | Rejected:
    """Return the answer to a question in an engine that only confirms the answer of another.

    It must pass the gates of the question. Gates on pictures and nudges are those of the other engine.
    """
    asking = _context(design, q, run, pair)

    def measured() -> Measurement:
        _, answer = _valid_answer(asking)
        return Measurement(answer, KINDS[answer.kind].words(asking, answer))

    made = _caught(measured)
    return rejected(design, instance, q, pair, made) if isinstance(made, Reject) else made


def rejected(
    design: Design, instance: Instance, q: int, pair: EnginePair, why: Reject, asking: QuestionContext | None = None
) -> Rejected:
    """Return a rejected question, with the label of its answer if `asking` has one."""
    label = _member(design, instance, q) or (answer_label(asking) if asking else "")
    return Rejected(design.spec.name, instance.index, q, pair.traces.engine, why.reason, why.detail, label)


def _context(design: Design, q: int, run: Run, pair: EnginePair) -> QuestionContext:
    return QuestionContext(design.spec.questions[q], run, pair)


def _caught(make: Callable[[], T]) -> T | Reject:
    """Return what `make` returns, or the reason for which it rejects the question."""
    try:
        return make()
    except Reject as reject:
        return reject
    except GraphicsError:
        raise
    except WmsError as error:
        return rejection_of(error)


def _valid_answer(asking: QuestionContext) -> tuple[float | None, Answer]:
    """Return the margin and the answer. Raises Reject if a gate that needs no pictures rejects it."""
    margin = smallest_margin(asking.question, asking.measured)
    kind = KINDS[asking.question.kind]
    answer = kind.answer(asking)
    kind.gate(asking, answer)
    return margin, answer


def _member(design: Design, instance: Instance, q: int) -> str:
    """Return the label of the instance in the closed set of a question; '' without one."""
    names = names_of(design.spec, instance.values)
    return member_label(design.spec.questions[q], instance.factors, names)


def groups(instance: Instance) -> dict[str, str]:
    """Return, for every factor, the key shared by instances that differ in that factor only."""
    own = (*instance.key[:2], instance.block)  # with the seed, or else trying all levels would recover them
    return {
        factor: f"{bits(*own, *(f'{k}={v}' for k, v in instance.factors.items() if k != factor)):016x}"
        for factor in instance.factors
    }


def answer_slot(design: Design, instance: Instance, q: int) -> AnswerSlot:
    """Return the place of the truth, balanced over the design and over every sample of it. It needs no execution."""
    if design.spec.questions[q].orbit:
        return closed_slot(design, instance, q)
    turn, place, many = design.sample_part(instance.index)
    position = turn * many + Permutation(many, design.seed, design.spec.name, q, turn, "position")(place)
    return ShuffledSlot(position, (design.seed, design.spec.name, instance.index, "order"))


def closed_slot(design: Design, instance: Instance, q: int) -> ClosedSlot:
    """Return the order of a closed set, equal for all members, so that the truth is at each place once.

    Over as many groups as there are members, every member has every place once.
    """
    question = design.spec.questions[q]
    members = [change.levels for change in question.counterfactuals]
    rest = [instance.factors[name] for name in instance.crossed if name not in members[0]]
    lap, turn = divmod(instance.block, len(members))
    shuffled = Permutation(len(members), design.seed, design.spec.name, q, *rest, lap, "places")
    places = tuple((shuffled(m) + turn) % len(members) for m in range(len(members)))
    own = next(m for m, levels in enumerate(members) if all(instance.factors[f] == x for f, x in levels.items()))
    return ClosedSlot(places, own)


def names_of(spec: TaskSpec, values: Mapping[str, Level]) -> dict[str, str]:
    """Return the names of the values of factors and nuisances that have names."""
    called = {factor.name: factor.called(values[factor.name]) for factor in spec.factors}
    return {name: words for name, words in called.items() if words is not None}


@dataclass(frozen=True)
class _Row:
    """Builds the row of a question."""

    design: Design
    instance: Instance
    q: int
    asking: QuestionContext

    def row(self) -> QuestionRow:
        """Return the question. Raises Reject if a gate rejects it."""
        spec, instance, asking = self.design.spec, self.instance, self.asking
        question, measured, pair, kind = asking.question, asking.measured, asking.pair, KINDS[asking.question.kind]
        margin, answer = _valid_answer(asking)
        require_stable(asking, answer, instance.key)
        self.visible(answer)
        options = kind.options(asking, answer, answer_slot(self.design, instance, self.q))
        names = referenced_objects(question, asking.values)
        difference = self.difference()
        channels = channels_of(spec)
        objects = tuple(self.objects(view, names) for view in asking.views)
        legible = legibility(asking, answer, options, objects)
        if question.legible:
            require_legible(legible)
        return QuestionRow(
            task=spec.name,
            dimension=spec.dimension,
            index=instance.index,
            block=instance.block,
            question=self.q,
            name=question.name,
            seed=self.design.seed,
            engine=pair.traces.engine,
            renderer=pair.renders.engine,
            text=question_text(question, measured, asking.values),
            context=tuple(self.picture(view, channels) for view in asking.views),
            options=options,
            answer=next((i for i, option in enumerate(options) if option.kind == "truth"), None),
            value=kind.words(asking, answer),
            number=kind.number(asking, answer),
            standing=not (kind.watched or is_measured(spec, question.answer)),
            moments=CHANGE if kind.watched else self.moments(),
            objects=objects,
            crossed=instance.crossed,
            redrawn=instance.redrawn if spec.plan.balance else None,
            difference=difference,
            factors=instance.factors,
            nuisances=instance.nuisances,
            groups=groups(instance),
            margin=margin,
            sorted_outcomes=any(question.kinds for question in spec.questions),
            levels=names_of(spec, instance.values),
            measured=measured.all_readings(),
            what_ifs=self.what_ifs(),
            actual=answer.actual_words,
            legibility=legible,
            label=_member(self.design, instance, self.q) or answer_label(asking),
            visible=self.visible_parts(names),
            evidence=answer,
            film_text=fill_template(question.film_text, measured, asking.values),
            action_text=fill_template(question.action_text, measured, asking.values),
        )

    def visible(self, answer: Answer) -> None:
        """Raise Reject unless everything that the question is about is visible, in the options too."""
        asking, kind = self.asking, KINDS[answer.kind]
        depicted = kind.option_images(asking, answer)
        runs = [asking.run, *asking.imagined, *(option.run for option in depicted)]
        things = {thing.name for thing in asking.values.spec.things}  # links of an arm may be hidden
        needed = referenced_objects(asking.question, asking.values).union(*(run.movers() & things for run in runs))
        needed |= asking.declared.required
        together = connected_sets(asking.values)
        require_visible(asking.observed, needed, together, asking.declared)
        for option in depicted:
            shown = option.run.observed([(option.camera, option.time)], asking.pair)
            require_visible_in(option.name, shown, needed, together, asking.declared)

    def visible_parts(self, names: Iterable[str]) -> tuple[VisiblePart, ...] | None:
        """Return the visible share of objects that may be hidden; None if no question of the task allows it."""
        if not any(question.visibility for question in self.design.spec.questions):
            return None
        declared = self.asking.declared
        return visible_parts(self.asking.observed, names if declared.unrestricted else declared.times)

    def picture(self, view: View, channels: frozenset[Channel]) -> Picture:
        """Return a picture with the channels that the spec requests."""
        run, (camera, time) = self.asking.run, view
        frame = run.draw(camera, time, self.asking.pair, depth="depth" in channels)
        if "ids" not in channels:
            return Picture(camera, time, frame.rgb, frame.depth)
        return Picture(camera, time, frame.rgb, frame.depth, frame.ids, tuple(b.name for b in run.scene.bodies))

    def objects(self, view: View, names: set[str]) -> tuple[VisibleObject, ...]:
        """Return the visible objects of a picture."""
        run, (camera, time) = self.asking.run, view
        return visible_objects(run, run.draw(camera, time, self.asking.pair), time, names)

    def moments(self) -> int:
        """Return how many moments show the answer, or suffice to predict it: what would be, or follows the pictures."""
        asking = self.asking
        shown = moments(self.design.spec, asking.question.answer)
        last = max((time for _, time in asking.views), default=0.0)
        predicted = asking.imagined or asking.run.scene.duration > last
        return min(shown, PREDICTED) if predicted else shown

    def what_ifs(self) -> tuple[Change, ...] | None:
        """Return the changes of the what-ifs of the question; None if no question of the task has some."""
        if not any(map(imagines, self.design.spec.questions)):
            return None
        before = self.asking.values
        imagined = [run.values for run in self.asking.imagined]
        return tuple(change_of(after.change, (), before, after) for after in imagined if after.change is not None)

    def difference(self) -> Strength | None:
        """Return the strength of the stimulus, if the question defines it."""
        stimulus = self.asking.question.difference
        if stimulus is None:
            return None
        return Strength(
            format_expression(stimulus.value), stimulus.unit, evaluate(stimulus.value, self.asking.measured)
        )
