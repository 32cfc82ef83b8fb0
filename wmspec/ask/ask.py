"""Asking an instance's questions in one engine: execute, check the gates, measure the answer, picture the options."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmspec.ask.gates import Reject, distinct, passed
from wmspec.ask.measure import Measured
from wmspec.ask.model import Asked, Change, Option, Picture, Reason, Rejected
from wmspec.ask.say import question_text, say
from wmspec.check.evaluate import evaluate
from wmspec.check.ir import Counterfactual, Question, TaskSpec
from wmspec.design.design import Design, Instance
from wmspec.design.draws import bits, permuted
from wmspec.design.values import Values
from wmspec.errors import EngineError, WmsError
from wmspec.execute.studio import Studio
from wmspec.execute.trace import Executor
from wmspec.scene.model import Frame, Scene, Shot, Trace
from wmspec.scene.read import read
from wmspec.stage.episode import document
from wmspec.stage.layers import compose

#: A body that covers less of a picture than this cannot be seen in it. (A 6 x 6 patch of 256 x 256 pixels.)
LEAST_VISIBLE = 36 / 256**2
#: Two option pictures in which fewer pixels than this show different bodies look alike.
LEAST_DIFFERENT = 100 / 256**2


@dataclass(frozen=True)
class Crew:
    """Who executes and who draws."""

    executor: Executor
    studio: Studio


@dataclass(frozen=True)
class _Run:
    """An executed episode."""

    values: Values
    scene: Scene
    trace: Trace

    def moving(self) -> list[int]:
        return [i for i, b in enumerate(self.scene.bodies) if b.motion != "static"]

    def poses(self, time: float) -> NDArray[np.float64]:
        """The poses (n, 7) of the bodies that can move."""
        i, moving = self.trace.sample(time), self.moving()
        return np.concatenate([self.trace.position[i, moving], self.trace.orientation[i, moving]], axis=1)


def ask(design: Design, index: int, crew: Crew) -> list[Asked | Rejected]:
    """Every question of an instance, each asked or rejected with its reason."""
    spec, instance = design.spec, design[index]
    try:
        run = _execute(spec, instance, None, crew)
    except EngineError as error:
        return [_rejected(spec, index, q, crew, "unstable", str(error)) for q in range(len(spec.questions))]
    except WmsError as error:
        return [_rejected(spec, index, q, crew, "invalid", str(error)) for q in range(len(spec.questions))]
    asked: list[Asked | Rejected] = []
    for q in range(len(spec.questions)):
        try:
            asked.append(_question(design, instance, q, run, crew))
        except Reject as reject:
            asked.append(_rejected(spec, index, q, crew, reject.reason, reject.detail))
    return asked


def _rejected(spec: TaskSpec, index: int, q: int, crew: Crew, reason: Reason, detail: str) -> Rejected:
    return Rejected(spec.name, index, q, crew.executor.engine, reason, detail)


def _execute(spec: TaskSpec, instance: Instance, change: Counterfactual | None, crew: Crew) -> _Run:
    scene = read(compose(document(spec, instance, change)))
    return _Run(Values(spec, instance.values, change), scene, crew.executor.trace(scene))


def _question(design: Design, instance: Instance, q: int, run: _Run, crew: Crew) -> Asked:
    spec, question = design.spec, design.spec.questions[q]
    looks = [(o.camera, t) for o in spec.observations for t in evaluate(o.times, run.values)]
    times = [t for _, t in looks]
    measured = Measured(run.values, run.trace, (min(times), max(times)))
    try:
        margin, answer = passed(question, measured), evaluate(question.answer, measured)
    except WmsError as error:  # a division by a speed of zero, say
        raise Reject("invalid", str(error)) from None
    context = tuple(_picture(run, camera, time, crew, f"at {time:g} s") for camera, time in looks)
    position = permuted(instance.index, len(design), design.seed, spec.name, q, "position")
    if question.options is None:
        options, truth, outcome = _pictured(design, instance, question, run, answer, crew, position)
        value = f"{answer[0]} at {answer[1]:g} s"
    else:
        options, truth = _labelled(question, answer, run.values, position, design, instance)
        outcome, value = None, say(answer, question.sort, run.values)
    return Asked(
        task=spec.name,
        dimension=spec.dimension,
        index=instance.index,
        block=instance.block,
        question=q,
        seed=design.seed,
        engine=crew.executor.engine,
        renderer=crew.studio.engine,
        text=question_text(question, measured, run.values),
        context=context,
        options=options,
        answer=truth,
        value=value,
        factors=instance.factors,
        nuisances=instance.nuisances,
        groups=groups(instance),
        margin=margin,
        measured=dict(sorted(measured.readings.items())),
        outcome=outcome,
    )


def groups(instance: Instance) -> dict[str, str]:
    """For every factor, the key that this instance shares with those that differ from it in that factor alone."""
    return {
        factor: f"{bits(instance.block, *(f'{k}={v}' for k, v in instance.factors.items() if k != factor)):016x}"
        for factor in instance.factors
    }


# ---------------------------------------------------------------- pictures


def _draw(run: _Run, camera: str, time: float, crew: Crew) -> Frame:
    return crew.studio.draw(run.scene, Shot(camera, run.trace.poses(time)))


def _picture(run: _Run, camera: str, time: float, crew: Crew, where: str) -> Picture:
    """A picture in which every moving body can be seen; rejects otherwise."""
    frame = _draw(run, camera, time, crew)
    least = LEAST_VISIBLE * frame.ids.size
    for i in run.moving():
        seen = int((frame.ids == i).sum())
        if seen < least:
            raise Reject("unseen", f"{run.scene.bodies[i].name} {where}: {seen} of {frame.ids.size} pixels")
    return Picture(camera, time, frame.rgb)


# ---------------------------------------------------------------- options


def _labelled(
    question: Question, answer: Any, values: Values, position: int, design: Design, instance: Instance
) -> tuple[tuple[Option, ...], int]:
    assert question.options is not None
    choices = list(evaluate(question.options, values))
    if answer not in choices:
        raise Reject("invalid", f"the answer {say(answer, question.sort, values)} is not among the options")
    texts = [say(c, question.sort, values) for c in choices]
    if len(set(texts)) < len(texts):
        raise Reject("alike", f"two options read the same: {', '.join(texts)}")
    order = _order(choices.index(answer), len(choices), position, design, instance)
    options = tuple(Option("truth" if choices[i] == answer else "label", str(choices[i]), text=texts[i]) for i in order)
    return options, position % len(choices)


def _pictured(
    design: Design, instance: Instance, question: Question, run: _Run, answer: Any, crew: Crew, position: int
) -> tuple[tuple[Option, ...], int, NDArray[np.float64]]:
    camera, time = answer
    runs: list[_Run] = [run]
    changes: list[Counterfactual | None] = [None, *question.counterfactuals]
    for counterfactual in question.counterfactuals:
        try:
            runs.append(_execute(design.spec, instance, counterfactual, crew))
        except EngineError as error:
            raise Reject("unstable", f"{counterfactual.name}: {error}") from None
        except WmsError as error:
            raise Reject("invalid", f"{counterfactual.name}: {error}") from None
    poses = np.stack([r.poses(time) for r in runs])
    names = ["truth", *(c.name for c in question.counterfactuals)]
    if question.distinct is not None:
        distinct(poses, names, evaluate(question.distinct, run.values))
    frames = [_draw(r, camera, time, crew) for r in runs]
    _look_different(frames, names)
    order = _order(0, len(runs), position, design, instance)
    options = []
    for i in order:
        picture = _picture(runs[i], camera, time, crew, f"in option {names[i]}")
        said = _change(change, run.values, runs[i].values) if (change := changes[i]) is not None else None
        options.append(Option("truth" if i == 0 else "counterfactual", names[i], picture=picture, change=said))
    return tuple(options), order.index(0), poses[order]


def _order(truth: int, n: int, position: int, design: Design, instance: Instance) -> list[int]:
    """The options in a seeded order with the truth at `position` modulo `n`: over the design, everywhere alike."""
    key = (design.seed, design.spec.name, instance.index, "order")
    others = sorted((i for i in range(n) if i != truth), key=lambda i: bits(*key, i))
    others.insert(position % n, truth)
    return others


def _look_different(frames: list[Frame], names: list[str]) -> None:
    for i, j in combinations(range(len(names)), 2):
        share = float((frames[i].ids != frames[j].ids).mean())
        if share < LEAST_DIFFERENT:
            raise Reject("alike", f"{names[i]} and {names[j]}: {share:.3%} of the picture differs")


def _change(change: Counterfactual, before: Values, after: Values) -> Change:
    """What a counterfactual changed, in words."""
    if change.value is None:
        return Change(change.change, change.owner, "done", "left out")
    owner, name = change.owner, change.property
    was = say(before.property(owner, name), change.sort, before) if before.has(owner, name) else "unset"
    return Change(change.change, f"{owner}.{name}", was, say(after.property(owner, name), change.sort, after))
