"""Questions with pictures as options: what happens, and what would have happened."""

from __future__ import annotations

import hashlib
import math
import pickle
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from wmspec.ask.asking import AnswerSlot, Asking
from wmspec.ask.changes import change_of
from wmspec.ask.kinds.kind import Depicted, Kind, Offered
from wmspec.ask.model import TRUTH, Answer, Option, Picture, Reject
from wmspec.ask.runs import Run
from wmspec.check.evaluate import evaluate
from wmspec.check.ir import Counterfactual, Question, QuestionKind
from wmspec.execute.render_cache import look_key
from wmspec.scene.model import Frame, Scene

#: Two option pictures in which fewer pixels than this show something different look alike.
LEAST_DIFFERENT = 100 / 256**2
#: After a nudge an outcome may have moved by this share of its distance to the nearest other option.
MOST_MOVED = 1 / 3
#: Outcomes whose distances (m) differ by less are equally far: what has moved by a micrometre has not.
AS_FAR = 1e-6


@dataclass(frozen=True)
class PictureAnswer(Answer):
    """The picture that is true, taken by `camera` at `time` (s), and what it is to be told from.

    Of every option, the truth first and then the counterfactuals: its name, where every body that can move in one of
    them is and how it is turned (`outcomes`: options, bodies, 7; NaN for what is not there), and its `looks`, a hash of
    everything else that the picture shows.
    """

    kind: ClassVar[QuestionKind] = "pictures"
    camera: str
    time: float
    names: tuple[str, ...]
    bodies: tuple[str, ...]
    outcomes: NDArray[np.float64]
    looks: tuple[str, ...]


class Pictures(Kind[PictureAnswer]):
    """The answer is the option whose outcome is nearest to what happens, and that looks like it."""

    def executed(self, question: Question) -> tuple[Counterfactual, ...]:
        """All of them: they are the options."""
        return question.counterfactuals

    def answer(self, asking: Asking) -> PictureAnswer:
        """Where everything is in every option. Raises WmsError if a picture is taken after the end of its episode."""
        camera, time = evaluate(asking.question.answer, asking.measured)
        runs = (asking.run, *asking.alternatives)
        bodies = tuple(dict.fromkeys(name for run in runs for name in run.movable()))
        return PictureAnswer(
            camera=camera,
            time=time,
            names=(TRUTH, *(change.name for change in asking.question.counterfactuals)),
            bodies=bodies,
            outcomes=np.stack([run.poses(bodies, time) for run in runs]),
            looks=tuple(appearance(run.scene) for run in runs),
        )

    def words(self, asking: Asking, answer: PictureAnswer) -> str:
        """Which picture it is."""
        return f"{answer.camera} at {answer.time:g} s"

    def gate(self, asking: Asking, answer: PictureAnswer) -> None:
        """Raise Reject if two options are nearer than `distinct` says, unless they differ in looks alone."""
        if asking.question.distinct is None:
            return
        least = evaluate(asking.question.distinct, asking.values)
        for i, j in combinations(range(len(answer.names)), 2):
            gap = apart(answer.outcomes[i], answer.outcomes[j])
            if gap < least and not (gap < AS_FAR and answer.looks[i] != answer.looks[j]):
                names = f"{answer.names[i]} and {answer.names[j]}"
                raise Reject("alike", f"{names}: {gap * 100:.1f} cm apart, {least * 100:.1f} cm asked for")

    def disturbed(self, asking: Asking, answer: PictureAnswer, nudged: Run, by: float) -> str:
        """Whether the outcome has moved far towards another option.

        Options that are nearer than the nudge itself differ in something else than places, such as a colour.
        """
        gaps = [apart(answer.outcomes[0], other) for other in answer.outcomes[1:]]
        moved = apart(answer.outcomes[0], nudged.poses(answer.bodies, answer.time))
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
        changes = (None, *asking.question.counterfactuals)
        options = []
        for i in slot.order(0, len(depicted)):
            picture, change = Picture(answer.camera, answer.time, frames[i].rgb), changes[i]
            if change is None:
                options.append(Option("truth", TRUTH, picture=picture))
            else:
                changed = change_of(change, asking.values, depicted[i].run.values)
                options.append(Option("counterfactual", change.name, picture=picture, change=changed))
        return tuple(options)

    def picked(self, mine: PictureAnswer, other: PictureAnswer) -> str | None:
        """The nearest option; of those that are as near, the one that looks like what happens in the other engine."""
        gaps = [apart(other.outcomes[0], outcome) for outcome in mine.outcomes]
        least = min(gaps)
        if math.isinf(least):
            return None
        nearest = [i for i, gap in enumerate(gaps) if gap <= least + AS_FAR]
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


def appearance(scene: Scene) -> str:
    """What a picture shows of a scene apart from where that is which can move, as a hash: looks, light, cameras.

    It is the same in all engines, which are given the same scene.
    """
    static = [body for body in scene.bodies if body.motion == "static"]
    fixed = [(b.name, b.pose.position.tobytes(), b.pose.orientation.tobytes()) for b in static]
    return hashlib.blake2b(pickle.dumps((look_key(scene), fixed), protocol=4), digest_size=16).hexdigest()


def _from(mine: PictureAnswer, other: PictureAnswer, name: str) -> str:
    gap = apart(other.outcomes[0], mine.outcomes[mine.names.index(name)])
    return f"{gap * 100:.1f} cm"


def _told_apart(depicted: Sequence[Depicted], frames: Sequence[Frame]) -> None:
    """Raise Reject if two pictures look alike."""
    numbers: dict[tuple[object, ...], int] = {}
    shown = [_shown(option.run.scene, frame, numbers) for option, frame in zip(depicted, frames, strict=True)]
    for i, j in combinations(range(len(shown)), 2):
        share = float((shown[i] != shown[j]).mean())
        if share < LEAST_DIFFERENT:
            raise Reject("alike", f"{depicted[i].name} and {depicted[j].name}: {share:.3%} of the picture differs")


def _shown(scene: Scene, frame: Frame, numbers: dict[tuple[object, ...], int]) -> NDArray[np.int64]:
    """The picture with a number for every body, its surfaces and the light on them, the same in all `numbers`."""
    light = pickle.dumps(scene.light)
    looks = [(b.name, tuple(g.surface for g in b.geoms if g.visible), light) for b in scene.bodies]
    table = [numbers.setdefault(look, len(numbers)) for look in (*looks, ("", scene.background))]
    return np.asarray(np.array(table)[frame.ids])  # -1, which is no body, is the last of them
