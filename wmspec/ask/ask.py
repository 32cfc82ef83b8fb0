"""Asking an instance's questions in one engine: execute, check the gates, measure the answer, picture the options."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmspec.ask.describe import Ambiguous
from wmspec.ask.gates import distinct, passed
from wmspec.ask.measure import Measured
from wmspec.ask.model import Number, Option, Picture, QuestionRow, Reason, Reject, Rejected, Strength
from wmspec.ask.options import Alternative, AnswerSlot, labelled, pictured
from wmspec.ask.robustness import stable, stable_picture
from wmspec.ask.runs import EnginePair, Run, execute
from wmspec.ask.verbalize import question_text, say_option, si_unit, written
from wmspec.ask.views import View, kept, looked
from wmspec.ask.visibility_gate import named, shown, shown_in
from wmspec.check.evaluate import evaluate
from wmspec.check.ir import Channel, Question, TaskSpec
from wmspec.check.measured import measured as is_measured
from wmspec.design.design import Design, Instance
from wmspec.diagnostics import GraphicsError, WmsError
from wmspec.draws import bits, permuted
from wmspec.layout.values import Values


def ask(design: Design, index: int, crew: EnginePair) -> list[QuestionRow | Rejected]:
    """Every question of an instance, each asked or rejected with its reason."""
    spec, instance = design.spec, design[index]
    numbers = range(len(spec.questions))
    try:
        run = execute(design, instance, None, crew)
    except Reject as reject:
        return [_rejected(spec, index, q, crew, reject.reason, reject.detail) for q in numbers]
    return [_tried(_Asking(design, instance, q, run, crew)) for q in numbers]


def _tried(asking: _Asking) -> QuestionRow | Rejected:
    spec, index, q, crew = asking.design.spec, asking.instance.index, asking.q, asking.crew
    try:
        return asking.asked()
    except Reject as reject:
        return _rejected(spec, index, q, crew, reject.reason, reject.detail)
    except Ambiguous as error:
        return _rejected(spec, index, q, crew, "alike", str(error))
    except GraphicsError:
        raise
    except WmsError as error:  # a division by a speed of zero, say
        return _rejected(spec, index, q, crew, "invalid", str(error))


def _rejected(spec: TaskSpec, index: int, q: int, crew: EnginePair, reason: Reason, detail: str) -> Rejected:
    return Rejected(spec.name, index, q, crew.executor.engine, reason, detail)


def groups(instance: Instance) -> dict[str, str]:
    """For every factor, the key that this instance shares with those that differ from it in that factor alone."""
    return {
        factor: f"{bits(instance.block, *(f'{k}={v}' for k, v in instance.factors.items() if k != factor)):016x}"
        for factor in instance.factors
    }


@dataclass(frozen=True)
class _Choice:
    """The options of a question, the place of the true one (None without options), and where bodies are in each."""

    options: tuple[Option, ...]
    truth: int | None
    outcome: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class _Asking:
    """One question of an executed instance."""

    design: Design
    instance: Instance
    q: int
    run: Run
    crew: EnginePair

    @property
    def question(self) -> Question:
        return self.design.spec.questions[self.q]

    @property
    def key(self) -> tuple[object, ...]:
        return self.design.seed, self.design.spec.name, self.instance.index

    def asked(self) -> QuestionRow:
        """The question. Raises Reject where it cannot be asked."""
        question, values, instance = self.question, self.run.values, self.instance
        looks, channels = looked(self.design.spec, values), kept(self.design.spec)
        measured = Measured(values, self.run.observed(looks, self.crew))
        margin, answer = passed(question, measured), evaluate(question.answer, measured)
        choice = self.choice(answer, looks)
        difference = self.difference(measured)
        return QuestionRow(
            task=self.design.spec.name,
            dimension=self.design.spec.dimension,
            index=instance.index,
            block=instance.block,
            question=self.q,
            name=question.name,
            seed=self.design.seed,
            engine=self.crew.executor.engine,
            renderer=self.crew.studio.engine,
            text=question_text(question, measured, values),
            context=tuple(self.picture(*look, channels) for look in looks),
            options=choice.options,
            answer=choice.truth,
            value=said_answer(question, answer, values),
            number=self.number(answer),
            standing=not is_measured(self.design.spec, question.answer),
            difference=difference,
            factors=instance.factors,
            nuisances=instance.nuisances,
            groups=groups(instance),
            margin=margin,
            measured=dict(sorted(measured.readings.items())),
            outcome=choice.outcome,
        )

    def choice(self, answer: Any, looks: Sequence[View]) -> _Choice:
        """The options, once the answer is known to hold and all that the question is about can be seen."""
        if self.question.sort == "picture":
            camera, time = answer
            return self.pictures(camera, time, looks)
        question, values = self.question, self.run.values
        open_ = question.within is not None
        choice = _Choice((), None) if open_ else _Choice(*labelled(question, answer, values, self.seat))
        stable(question, self.run, answer, looks, self.key, self.crew)
        shown(self.run.observed(looks, self.crew), named(question, values) | self.run.movers())
        return choice

    def pictures(self, camera: str, time: float, looks: Sequence[View]) -> _Choice:
        """The pictures of what happens and of what would have happened."""
        question, changes = self.question, [None, *self.question.counterfactuals]
        runs = [self.run] + [execute(self.design, self.instance, c, self.crew) for c in changes[1:]]
        names = list(dict.fromkeys(name for run in runs for name in run.movable()))
        outcome = np.stack([run.poses(names, time) for run in runs])
        said = ["truth", *(c.name for c in question.counterfactuals)]
        if question.distinct is not None:
            distinct(outcome, said, evaluate(question.distinct, self.run.values))
        stable_picture(question, self.run, time, names, outcome, self.key, self.crew)
        needed = named(question, self.run.values).union(*(run.movers() for run in runs))
        shown(self.run.observed(looks, self.crew), needed)
        for run, name in zip(runs, said, strict=True):
            shown_in(name, run.observed([(camera, time)], self.crew), needed)
        frames = [run.draw(camera, time, self.crew) for run in runs]
        alternatives = [Alternative(*parts) for parts in zip(runs, changes, frames, strict=True)]
        options, order = pictured(alternatives, camera, time, self.seat)
        return _Choice(options, order.index(0), outcome[order])

    @property
    def seat(self) -> AnswerSlot:
        """The truth's place among the options: over the design, everywhere alike."""
        index, (seed, name, _) = self.instance.index, self.key
        position = permuted(index, len(self.design), seed, name, self.q, "position")
        return AnswerSlot(position, (*self.key, "order"))

    def picture(self, camera: str, time: float, channels: frozenset[Channel]) -> Picture:
        """A picture with what the spec asks for of it."""
        frame = self.run.draw(camera, time, self.crew, depth="depth" in channels)
        if "ids" not in channels:
            return Picture(camera, time, frame.rgb, frame.depth)
        return Picture(camera, time, frame.rgb, frame.depth, frame.ids, tuple(b.name for b in self.run.scene.bodies))

    def number(self, answer: Any) -> Number | None:
        """The answer as a number, if it is one."""
        if not isinstance(answer, float):
            return None
        within = self.question.within
        return Number(
            answer, si_unit(self.question.sort), None if within is None else evaluate(within, self.run.values)
        )

    def difference(self, measured: Measured) -> Strength | None:
        """How strong the stimulus is, if the question says."""
        said = self.question.difference
        return None if said is None else Strength(written(said.value), said.unit, evaluate(said.value, measured))


def said_answer(question: Question, answer: Any, values: Values) -> str:
    """An answer in words; of a picture, which it is."""
    if question.sort == "picture":
        return f"{answer[0]} at {answer[1]:g} s"
    return say_option(answer, question.sort, values)
