"""Questions with pictures as options: the outcome, and counterfactual outcomes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from wmspec.compile.design.about import referenced_objects
from wmspec.core.memoize import cached_on
from wmspec.lang.check.ir.evaluate import evaluate, resolved
from wmspec.lang.check.ir.ir import ACTUAL, Counterfactual, Level, OrbitFactor, Outcome, Question, QuestionKind, WhatIf
from wmspec.runtime.caches.cache_keys import look_key
from wmspec.runtime.questions.changes import change_of
from wmspec.runtime.questions.kinds.kind import Kind, OptionImage
from wmspec.runtime.questions.measure import Measured
from wmspec.runtime.questions.model import TRUTH, Answer, Option, OptionKind, Picture, Reject
from wmspec.runtime.questions.picture_balance import MIN_DIFFERENT_SHARE
from wmspec.runtime.questions.question_context import AnswerSlot, QuestionContext
from wmspec.runtime.questions.runs import Run
from wmspec.runtime.questions.visible_object import visible_objects
from wmspec.sim.scene.model import Body, Frame, Pose, Scene
from wmspec.sim.scene.model.digest import digest
from wmspec.sim.scene.render.appearance import appearance_at
from wmspec.sim.scene.render.visible_rotation import symmetry_axis, visible_angle_about

#: Largest movement of an outcome under a nudge, relative to the nearest other option.
MAX_MOVED_SHARE = 1 / 3
#: Decimals to which places (m) and rotations of geoms are compared.
PLACE_DECIMALS = 9
#: rad: smaller differences of rotation are ignored.
ANGLE_TOLERANCE = 1e-6
#: m: smaller differences of distance are ignored.
DISTANCE_TOLERANCE = 1e-6


@dataclass(frozen=True)
class PictureAnswer(Answer):
    """The true picture, taken by `camera` at `time` (s), and its alternatives.

    For every option, truth first: its name, the poses of all bodies that are movable in any option (`outcomes`:
    options, bodies, 7; NaN if absent), `looks`, a hash of everything else that the picture shows, and the kind of the
    outcome (`outcome_kinds`, empty without kinds).

    `axes` (bodies, 3) are symmetry axes as returned by `visible_rotation.symmetry_axis`. A rotation of 1 rad counts
    like `lever` metres; 0 ignores rotations.
    """

    kind: ClassVar[QuestionKind] = "pictures"
    camera: str
    time: float
    names: tuple[str, ...]
    bodies: tuple[str, ...]
    outcomes: NDArray[np.float64]
    looks: tuple[str, ...]
    axes: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))
    lever: float = 0.0
    outcome_kinds: tuple[str, ...] = ()

    def distance(self, a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
        """Return the distance (m) of two outcomes: the largest over all bodies, rotations included."""
        return max(max_distance(a, b), self.lever * max_rotation(self.axes, a, b) if self.lever else 0.0)


class Pictures(Kind[PictureAnswer]):
    """The answer is the option whose outcome and appearance are closest to the truth."""

    def executed(self, question: Question, levels: Mapping[str, Level]) -> tuple[Counterfactual, ...]:
        """Return all counterfactuals, which are the options."""
        return question.alternatives(levels)

    def answer(self, asking: QuestionContext) -> PictureAnswer:
        """Return the poses in every option. Raises WmsError if a picture is taken after the end of its episode."""
        camera, time = evaluate(asking.question.answer, asking.measured)
        shown, question = _option_runs(asking), asking.question
        runs = [option.run for option in shown]
        bodies = tuple(dict.fromkeys(name for run in runs for name in run.movable()))
        lever = 0.0
        if question.distinct is not None and question.distinct_turn is not None:
            lever = evaluate(question.distinct, asking.values) / evaluate(question.distinct_turn, asking.values)
        return PictureAnswer(
            camera=camera,
            time=time,
            names=tuple(option.name for option in shown),
            bodies=bodies,
            outcomes=np.stack([run.poses(bodies, time) for run in runs]),
            looks=tuple(appearance(appearance_at(run.scene, time)) for run in runs),
            axes=_axes(runs, bodies),
            lever=lever,
            outcome_kinds=tuple(_outcome_kinds(asking, shown)),
        )

    def words(self, asking: QuestionContext, answer: PictureAnswer) -> str:
        """Return which picture it is."""
        return f"{answer.camera} at {answer.time:g} s"

    def vote_words(self, value: str, option: int | None) -> str:
        """Return which picture an engine selects."""
        return "picks no picture" if option is None else f"picks picture {option + 1}"

    def gate(self, asking: QuestionContext, answer: PictureAnswer) -> None:
        """Raise Reject if two options are closer than `distinct`, unless they differ in appearance only."""
        question = asking.question
        least = None if question.distinct is None else evaluate(question.distinct, asking.values)
        for i, j in combinations(range(len(answer.names)), 2):
            names = f"{answer.names[i]} and {answer.names[j]}"
            if question.distinct_kinds and answer.outcome_kinds[i] == answer.outcome_kinds[j]:
                raise Reject("alike", f"{names}: both are of the kind `{answer.outcome_kinds[i]}`")
            gap = answer.distance(answer.outcomes[i], answer.outcomes[j])
            if least is None or gap >= least or (gap < DISTANCE_TOLERANCE and answer.looks[i] != answer.looks[j]):
                continue
            away = max_distance(answer.outcomes[i], answer.outcomes[j])
            detail = f"{names}: {away * 100:.1f} cm apart, {least * 100:.1f} cm required"
            if answer.lever:
                turn = max_rotation(answer.axes, answer.outcomes[i], answer.outcomes[j])
                detail += (
                    f", or rotated by {math.degrees(turn):.0f}°, {math.degrees(least / answer.lever):.0f}° required"
                )
            raise Reject("alike", detail)

    def change_under_nudge(self, asking: QuestionContext, answer: PictureAnswer, nudged: Run, by: float) -> str:
        """Return how far the outcome moves towards another option, or ''.

        Options closer than the nudge itself differ in something other than place, such as colour.
        """
        gaps = [answer.distance(answer.outcomes[0], other) for other in answer.outcomes[1:]]
        run = _answer_run(asking.question, nudged)
        moved = answer.distance(answer.outcomes[0], run.poses(answer.bodies, answer.time))
        nearest = min((gap for gap in gaps if gap > by), default=math.inf)
        if moved <= MAX_MOVED_SHARE * nearest:
            return ""
        return (
            f"displaced by {by * 1000:g} mm it ends {moved * 100:.1f} cm from where it was, "
            f"and the nearest other option is {nearest * 100:.1f} cm away"
        )

    def option_images(self, asking: QuestionContext, answer: PictureAnswer) -> Sequence[OptionImage]:
        """Return all options."""
        return [OptionImage(option.name, option.run, answer.camera, answer.time) for option in _option_runs(asking)]

    def options(self, asking: QuestionContext, answer: PictureAnswer, slot: AnswerSlot) -> tuple[Option, ...]:
        """Return true and counterfactual outcomes, drawn."""
        depicted = self.option_images(asking, answer)
        frames = [option.run.draw(option.camera, option.time, asking.pair) for option in depicted]
        _require_distinct_images(depicted, frames)
        names = referenced_objects(asking.question, asking.values)
        objects = [visible_objects(d.run, frame, d.time, names) for d, frame in zip(depicted, frames, strict=True)]
        shown, outcomes = _option_runs(asking), answer.outcome_kinds or (None,) * len(depicted)
        options = []
        for i in slot.order(0, len(depicted)):
            picture, change = Picture(answer.camera, answer.time, frames[i].rgb), shown[i].change
            if change is None:
                kind: OptionKind = "truth" if i == 0 else "actual"
                options.append(Option(kind, shown[i].name, picture=picture, outcome=outcomes[i], objects=objects[i]))
            else:
                changed = change_of(change, asking.question.orbit, asking.values, depicted[i].run.values)
                kind = _kind(asking.question.orbit, change, asking.values.own)
                options.append(Option(kind, change.name, None, picture, changed, outcomes[i], objects[i]))
        return tuple(options)

    def picked(self, mine: PictureAnswer, other: PictureAnswer) -> str | None:
        """Return the option closest to the outcome of the other engine.

        Ties are broken by rotation, then by appearance.
        """
        gaps = [mine.distance(other.outcomes[0], outcome) for outcome in mine.outcomes]
        least = min(gaps)
        if math.isinf(least):
            return None
        nearest = [i for i, gap in enumerate(gaps) if gap <= least + DISTANCE_TOLERANCE]
        if len(nearest) > 1:
            turns = [max_rotation(mine.axes, other.outcomes[0], mine.outcomes[i]) for i in nearest]
            nearest = [i for i, turn in zip(nearest, turns, strict=True) if turn <= min(turns) + ANGLE_TOLERANCE]
        if len(nearest) > 1:
            nearest = [i for i in nearest if mine.looks[i] == other.looks[0]]
        return mine.names[nearest[0]] if len(nearest) == 1 else None

    def agree(self, a: PictureAnswer, b: PictureAnswer) -> bool:
        """Whether the outcome of each engine is the truth of the other."""
        return self.picked(a, b) == self.picked(b, a) == TRUTH

    def compared(self, a: PictureAnswer, b: PictureAnswer, engines: tuple[str, str]) -> str:
        """Return the distances of each outcome to the options of the other."""
        sentences = []
        for mine, other, (here, there) in ((a, b, engines), (b, a, engines[::-1])):
            pick = self.picked(mine, other)
            if pick is None:
                sentences.append(f"what happens in {there} is as far from several options in {here}")
            elif pick != TRUTH:
                sentences.append(
                    f"what happens in {there} is {_from(mine, other, pick)} from `{pick}` "
                    f"but {_from(mine, other, TRUTH)} from the truth in {here}"
                )
        return "; ".join(sentences) or f"the outcomes are {_from(a, b, TRUTH)} apart"

    def remedy(self, sort: str) -> str:
        """Return the remedy: larger differences between options."""
        return "use options that are further apart (`distinct by`)"


def max_distance(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Return the largest distance (m) of a body between two outcomes (n, 7); infinite if absent in one (NaN)."""
    gaps = np.linalg.norm(a[:, :3] - b[:, :3], axis=1)
    gone = np.isnan(a[:, 0]), np.isnan(b[:, 0])
    gaps = np.where(gone[0] != gone[1], np.inf, np.where(gone[0], 0.0, gaps))
    return float(gaps.max(initial=0.0))


def max_rotation(axes: NDArray[np.float64], a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Return the largest visible rotation (rad) of a body between two outcomes (n, 7), with symmetry `axes` (n, 3).

    Bodies absent in one outcome do not count.
    """
    turns = (visible_angle_about(axes[k], a[k : k + 1, 3:], b[k : k + 1, 3:]) for k in range(len(axes)))
    return max((float(turn[0]) for turn in turns if not np.isnan(turn[0])), default=0.0)


def _axes(runs: Sequence[Run], bodies: Sequence[str]) -> NDArray[np.float64]:
    """Return the symmetry axes of bodies; none if the shape differs between runs."""
    rows = []
    for name in bodies:
        there = [symmetry_axis(body) for run in runs for body in run.scene.bodies if body.name == name]
        same = all(np.array_equal(one, there[0], equal_nan=True) for one in there)
        rows.append(there[0] if same else np.full(3, np.nan))
    return np.array(rows).reshape(-1, 3)


@dataclass(frozen=True)
class _OptionRun:
    """An option: its name, its run, and its change if it is a counterfactual."""

    name: str
    run: Run
    change: Counterfactual | None = None


def _answer_run(question: Question, run: Run) -> Run:
    """Return the run that the true picture shows: of a what-if, the one with its change."""
    if isinstance(question.answer, WhatIf):
        return run.under(resolved(question.answer.change, run.values))
    return run


def _option_runs(asking: QuestionContext) -> list[_OptionRun]:
    """Return the runs of all options, truth first; beside a what-if, what happens without its change is second."""
    truth = _answer_run(asking.question, asking.run)
    actual = [] if truth is asking.run else [_OptionRun(ACTUAL, asking.run)]
    others = zip(asking.changes, asking.alternatives, strict=True)
    return [_OptionRun(TRUTH, truth), *actual, *(_OptionRun(change.name, run, change) for change, run in others)]


def _outcome_kinds(asking: QuestionContext, shown: Sequence[_OptionRun]) -> Iterator[str]:
    """Yield the kinds of the outcomes of all options. Raises Reject for an outcome of no kind."""
    for option in shown if asking.question.kinds else ():
        measured = asking.measured if option.run is asking.run else asking.measured_on(option.run)
        yield _outcome_kind(asking.question.kinds, option.name, measured)


def _outcome_kind(kinds: Sequence[Outcome], option: str, measured: Measured) -> str:
    for kind in kinds:
        if evaluate(kind.condition, measured):
            return kind.name
    raise Reject("ensure", f"{option} matches none of the kinds {', '.join(kind.name for kind in kinds)}")


def _kind(orbit: Sequence[OrbitFactor], change: Counterfactual, own: Mapping[str, Level]) -> OptionKind:
    """Return the kind of a wrong option; of a closed set, by its difference to the truth."""
    reads = {varied.reads for varied in orbit if change.levels[varied.factor] != own[varied.factor]}
    if not orbit:
        return "counterfactual"
    return reads.pop() if len(reads) == 1 else "both"


def appearance(scene: Scene) -> str:
    """Return a hash of everything that a picture shows except poses of movable bodies: materials, light, cameras.

    It is equal in all engines, because they receive the same scene.
    """
    static = [body for body in scene.bodies if body.motion == "static"]
    fixed = [(b.name, b.pose.position.tobytes(), b.pose.orientation.tobytes()) for b in static]
    looks = look_key(replace(scene, bodies=tuple(cached_on(body, _without_rounding) for body in scene.bodies)))
    return digest(looks, fixed).hex()


def _without_rounding(body: Body) -> Body:
    return replace(body, geoms=tuple(replace(geom, pose=_rounded(geom.pose)) for geom in body.geoms))


def _rounded(pose: Pose) -> Pose:
    """Return the pose of a geom in its body without round-off from the body's rotation."""
    return Pose(np.round(pose.position, PLACE_DECIMALS) + 0.0, np.round(pose.orientation, PLACE_DECIMALS) + 0.0)


def _from(mine: PictureAnswer, other: PictureAnswer, name: str) -> str:
    gap = max_distance(other.outcomes[0], mine.outcomes[mine.names.index(name)])
    return f"{gap * 100:.1f} cm"


def _require_distinct_images(depicted: Sequence[OptionImage], frames: Sequence[Frame]) -> None:
    """Raise Reject if two pictures look alike."""
    numbers: dict[tuple[object, ...], int] = {}
    shown = [
        _id_image(appearance_at(option.run.scene, option.time), frame, numbers)
        for option, frame in zip(depicted, frames, strict=True)
    ]
    for i, j in combinations(range(len(shown)), 2):
        share = float((shown[i] != shown[j]).mean())
        if share < MIN_DIFFERENT_SHARE:
            raise Reject("alike", f"{depicted[i].name} and {depicted[j].name}: {share:.3%} of the picture differs")


def _id_image(scene: Scene, frame: Frame, numbers: dict[tuple[object, ...], int]) -> NDArray[np.int64]:
    """Return a picture of numbers for body, surface and light, consistent across `numbers`."""
    light = digest(scene.light)
    looks = [(b.name, tuple(g.surface for g in b.geoms if g.visible), light) for b in scene.bodies]
    table = [numbers.setdefault(look, len(numbers)) for look in (*looks, ("", scene.background))]
    return np.asarray(np.array(table)[frame.ids])  # -1, the background, indexes the last entry
