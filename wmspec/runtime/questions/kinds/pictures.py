"""Questions with pictures as options: what happens, and what would have happened."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from wmspec.compile.design.about import named
from wmspec.core.memoize import cached_on
from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.lang.check.ir.ir import Counterfactual, Level, Outcome, Question, QuestionKind, Varied
from wmspec.runtime.caches.cache_keys import look_key
from wmspec.runtime.questions.changes import change_of
from wmspec.runtime.questions.kinds.kind import Depicted, Kind, Offered
from wmspec.runtime.questions.measure import Measured
from wmspec.runtime.questions.model import TRUTH, Answer, Option, OptionKind, Picture, Reject
from wmspec.runtime.questions.question_context import AnswerSlot, Asking
from wmspec.runtime.questions.runs import Run
from wmspec.runtime.questions.visible_object import sightings
from wmspec.sim.scene.model import Body, Frame, Pose, Scene
from wmspec.sim.scene.model.digest import digest
from wmspec.sim.scene.render.appearance import shown_at
from wmspec.sim.scene.render.turn import axis, visibly_turned

#: Two option pictures in which fewer pixels than this show something different look alike.
LEAST_DIFFERENT = 100 / 256**2
#: After a nudge an outcome may have moved by this share of its distance to the nearest other option.
MOST_MOVED = 1 / 3
#: Places (m) and turns of pieces that differ only beyond so many decimals are the same.
ROUNDED = 9
#: Turns (rad) that differ by less are the same.
AS_TURNED = 1e-6
#: Outcomes whose distances (m) differ by less are equally far: what has moved by a micrometre has not.
AS_FAR = 1e-6


@dataclass(frozen=True)
class PictureAnswer(Answer):
    """The picture that is true, taken by `camera` at `time` (s), and what it is to be told from.

    Of every option, the truth first and then the counterfactuals: its name, where every body that can move in one of
    them is and how it is turned (`outcomes`: options, bodies, 7; NaN for what is not there), its `looks`, a hash of
    everything else that the picture shows, and the kind of the outcome (`outcome_kinds`, empty if there are none).

    `axes` (bodies, 3) are about what bodies turn unseen, as `render.turn.axis` returns it. A turn of 1 rad counts as
    much as `lever` metres; 0 where turns do not count.
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

    def apart(self, a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
        """How far (m) two outcomes (bodies, 7) are apart in that which differs most, turns counted in."""
        return max(apart(a, b), self.lever * turn_between(self.axes, a, b) if self.lever else 0.0)


class Pictures(Kind[PictureAnswer]):
    """The answer is the option whose outcome is nearest to what happens, and that looks like it."""

    def executed(self, question: Question, levels: Mapping[str, Level]) -> tuple[Counterfactual, ...]:
        """All of them: they are the options."""
        return question.alternatives(levels)

    def answer(self, asking: Asking) -> PictureAnswer:
        """Where everything is in every option. Raises WmsError if a picture is taken after the end of its episode."""
        camera, time = evaluate(asking.question.answer, asking.measured)
        runs, question = (asking.run, *asking.alternatives), asking.question
        bodies = tuple(dict.fromkeys(name for run in runs for name in run.movable()))
        lever = 0.0
        if question.distinct is not None and question.distinct_turn is not None:
            lever = evaluate(question.distinct, asking.values) / evaluate(question.distinct_turn, asking.values)
        return PictureAnswer(
            camera=camera,
            time=time,
            names=(TRUTH, *(change.name for change in asking.changes)),
            bodies=bodies,
            outcomes=np.stack([run.poses(bodies, time) for run in runs]),
            looks=tuple(appearance(shown_at(run.scene, time)) for run in runs),
            axes=_axes(runs, bodies),
            lever=lever,
            outcome_kinds=tuple(_outcome_kinds(asking)),
        )

    def words(self, asking: Asking, answer: PictureAnswer) -> str:
        """Which picture it is."""
        return f"{answer.camera} at {answer.time:g} s"

    def gate(self, asking: Asking, answer: PictureAnswer) -> None:
        """Raise Reject if two options are nearer than `distinct` says, unless they differ in looks alone."""
        question = asking.question
        least = None if question.distinct is None else evaluate(question.distinct, asking.values)
        for i, j in combinations(range(len(answer.names)), 2):
            names = f"{answer.names[i]} and {answer.names[j]}"
            if question.distinct_kinds and answer.outcome_kinds[i] == answer.outcome_kinds[j]:
                raise Reject("alike", f"{names}: both are of the kind `{answer.outcome_kinds[i]}`")
            gap = answer.apart(answer.outcomes[i], answer.outcomes[j])
            if least is None or gap >= least or (gap < AS_FAR and answer.looks[i] != answer.looks[j]):
                continue
            away = apart(answer.outcomes[i], answer.outcomes[j])
            told = f"{names}: {away * 100:.1f} cm apart, {least * 100:.1f} cm asked for"
            if answer.lever:
                turn = turn_between(answer.axes, answer.outcomes[i], answer.outcomes[j])
                told += f", or turned by {math.degrees(turn):.0f}°, {math.degrees(least / answer.lever):.0f}° asked for"
            raise Reject("alike", told)

    def disturbed(self, asking: Asking, answer: PictureAnswer, nudged: Run, by: float) -> str:
        """Whether the outcome has moved far towards another option.

        Options that are nearer than the nudge itself differ in something else than places, such as a colour.
        """
        gaps = [answer.apart(answer.outcomes[0], other) for other in answer.outcomes[1:]]
        moved = answer.apart(answer.outcomes[0], nudged.poses(answer.bodies, answer.time))
        nearest = min((gap for gap in gaps if gap > by), default=math.inf)
        if moved <= MOST_MOVED * nearest:
            return ""
        return (
            f"set aside by {by * 1000:g} mm it ends {moved * 100:.1f} cm from where it was, "
            f"and the nearest other option is {nearest * 100:.1f} cm away"
        )

    def depicted(self, asking: Asking, answer: PictureAnswer) -> Sequence[Depicted]:
        """Every option."""
        runs = (asking.run, *asking.alternatives)
        return [Depicted(name, run, answer.camera, answer.time) for name, run in zip(answer.names, runs, strict=True)]

    def options(self, asking: Asking, answer: PictureAnswer, slot: AnswerSlot) -> tuple[Option, ...]:
        """What happens and what would have happened, drawn."""
        depicted = self.depicted(asking, answer)
        frames = [option.run.draw(option.camera, option.time, asking.pair) for option in depicted]
        _told_apart(depicted, frames)
        names = named(asking.question, asking.values)
        objects = [sightings(d.run, frame, d.time, names) for d, frame in zip(depicted, frames, strict=True)]
        changes, outcomes = (None, *asking.changes), answer.outcome_kinds or (None,) * len(depicted)
        options = []
        for i in slot.order(0, len(depicted)):
            picture, change = Picture(answer.camera, answer.time, frames[i].rgb), changes[i]
            if change is None:
                options.append(Option("truth", TRUTH, picture=picture, outcome=outcomes[i], objects=objects[i]))
            else:
                changed = change_of(change, asking.question.orbit, asking.values, depicted[i].run.values)
                kind = _kind(asking.question.orbit, change, asking.values.own)
                options.append(Option(kind, change.name, None, picture, changed, outcomes[i], objects[i]))
        return tuple(options)

    def picked(self, mine: PictureAnswer, other: PictureAnswer) -> str | None:
        """The option that is nearest to what happens in the other engine.

        Of those that are as near, the one that is turned so, and then the one that looks like it.
        """
        gaps = [mine.apart(other.outcomes[0], outcome) for outcome in mine.outcomes]
        least = min(gaps)
        if math.isinf(least):
            return None
        nearest = [i for i, gap in enumerate(gaps) if gap <= least + AS_FAR]
        if len(nearest) > 1:
            turns = [turn_between(mine.axes, other.outcomes[0], mine.outcomes[i]) for i in nearest]
            nearest = [i for i, turn in zip(nearest, turns, strict=True) if turn <= min(turns) + AS_TURNED]
        if len(nearest) > 1:
            nearest = [i for i in nearest if mine.looks[i] == other.looks[0]]
        return mine.names[nearest[0]] if len(nearest) == 1 else None

    def agree(self, a: PictureAnswer, b: PictureAnswer) -> bool:
        """Whether what happens in each is the truth in the other."""
        return self.picked(a, b) == self.picked(b, a) == TRUTH

    def compared(self, a: PictureAnswer, b: PictureAnswer, engines: tuple[str, str]) -> str:
        """How far what happens in each is from the options of the other."""
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
        """Options may be further apart."""
        return "ask for options that are further apart, with `distinct by`"

    def offered(self, options: Sequence[Option]) -> Offered:
        """Pictures."""
        return Offered(None, tuple(option.picture for option in options if option.picture is not None))


def apart(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """How far (m) the body that differs most between two outcomes (n, 7) is from itself.

    Infinitely far if it is in one of them alone (NaN in the other).
    """
    gaps = np.linalg.norm(a[:, :3] - b[:, :3], axis=1)
    gone = np.isnan(a[:, 0]), np.isnan(b[:, 0])
    gaps = np.where(gone[0] != gone[1], np.inf, np.where(gone[0], 0.0, gaps))
    return float(gaps.max(initial=0.0))


def turn_between(axes: NDArray[np.float64], a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """By how much (rad) the body is visibly turned that is turned most between two outcomes (n, 7).

    `axes` (n, 3) say what turns unseen. What is in one of them alone is not turned.
    """
    turns = (visibly_turned(axes[k], a[k : k + 1, 3:], b[k : k + 1, 3:]) for k in range(len(axes)))
    return max((float(turn[0]) for turn in turns if not np.isnan(turn[0])), default=0.0)


def _axes(runs: Sequence[Run], bodies: Sequence[str]) -> NDArray[np.float64]:
    """About what the bodies turn unseen; what is another shape in another run hides no turn."""
    rows = []
    for name in bodies:
        there = [axis(body) for run in runs for body in run.scene.bodies if body.name == name]
        same = all(np.array_equal(one, there[0], equal_nan=True) for one in there)
        rows.append(there[0] if same else np.full(3, np.nan))
    return np.array(rows).reshape(-1, 3)


def _outcome_kinds(asking: Asking) -> Iterator[str]:
    """Of what kind what happens is, and what would have happened. Raises Reject for what is of none."""
    if not asking.question.kinds:
        return
    yield _outcome_kind(asking.question.kinds, TRUTH, asking.measured)
    for change, run in zip(asking.changes, asking.alternatives, strict=True):
        yield _outcome_kind(asking.question.kinds, change.name, asking.measured_on(run))


def _outcome_kind(kinds: Sequence[Outcome], option: str, measured: Measured) -> str:
    for kind in kinds:
        if evaluate(kind.condition, measured):
            return kind.name
    raise Reject("ensure", f"{option} is of none of the kinds {', '.join(kind.name for kind in kinds)}")


def _kind(orbit: Sequence[Varied], change: Counterfactual, own: Mapping[str, Level]) -> OptionKind:
    """What an option is that is not true: of a closed set, in what it differs from the truth."""
    reads = {varied.reads for varied in orbit if change.levels[varied.factor] != own[varied.factor]}
    if not orbit:
        return "counterfactual"
    return reads.pop() if len(reads) == 1 else "both"


def appearance(scene: Scene) -> str:
    """What a picture shows of a scene apart from where that is which can move, as a hash: looks, light, cameras.

    It is the same in all engines, which are given the same scene.
    """
    static = [body for body in scene.bodies if body.motion == "static"]
    fixed = [(b.name, b.pose.position.tobytes(), b.pose.orientation.tobytes()) for b in static]
    looks = look_key(replace(scene, bodies=tuple(cached_on(body, _without_rounding) for body in scene.bodies)))
    return digest(looks, fixed).hex()


def _without_rounding(body: Body) -> Body:
    return replace(body, geoms=tuple(replace(geom, pose=_rounded(geom.pose)) for geom in body.geoms))


def _rounded(pose: Pose) -> Pose:
    """Where a piece is in its body, which depends on how that is turned only by rounding."""
    return Pose(np.round(pose.position, ROUNDED) + 0.0, np.round(pose.orientation, ROUNDED) + 0.0)


def _from(mine: PictureAnswer, other: PictureAnswer, name: str) -> str:
    gap = apart(other.outcomes[0], mine.outcomes[mine.names.index(name)])
    return f"{gap * 100:.1f} cm"


def _told_apart(depicted: Sequence[Depicted], frames: Sequence[Frame]) -> None:
    """Raise Reject if two pictures look alike."""
    numbers: dict[tuple[object, ...], int] = {}
    shown = [
        _shown(shown_at(option.run.scene, option.time), frame, numbers)
        for option, frame in zip(depicted, frames, strict=True)
    ]
    for i, j in combinations(range(len(shown)), 2):
        share = float((shown[i] != shown[j]).mean())
        if share < LEAST_DIFFERENT:
            raise Reject("alike", f"{depicted[i].name} and {depicted[j].name}: {share:.3%} of the picture differs")


def _shown(scene: Scene, frame: Frame, numbers: dict[tuple[object, ...], int]) -> NDArray[np.int64]:
    """The picture with a number for every body, its surfaces and the light on them, the same in all `numbers`."""
    light = digest(scene.light)
    looks = [(b.name, tuple(g.surface for g in b.geoms if g.visible), light) for b in scene.bodies]
    table = [numbers.setdefault(look, len(numbers)) for look in (*looks, ("", scene.background))]
    return np.asarray(np.array(table)[frame.ids])  # -1, which is no body, is the last of them
