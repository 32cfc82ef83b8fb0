"""Questions whether an episode is possible.

An episode is possible if it is the same without the actions that break the laws of physics, such as `vanish`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import ClassVar

from wmspec.core.diagnostics import WmsError
from wmspec.lang.check.ir.ir import QuestionKind
from wmspec.lang.check.statements.possibility import IMPOSSIBLE, POSSIBLE, VIOLATIONS
from wmspec.runtime.questions.kinds.kind import Kind
from wmspec.runtime.questions.model import Answer, Option, Reject
from wmspec.runtime.questions.observed import MIN_MOTION
from wmspec.runtime.questions.picture_balance import MIN_DIFFERENT_SHARE, different_share
from wmspec.runtime.questions.question_context import AnswerSlot, QuestionContext
from wmspec.runtime.questions.runs import Run
from wmspec.sim.scene.model import Scene
from wmspec.sim.scene.render.appearance import appearance_at

_OPTIONS = (POSSIBLE, IMPOSSIBLE)


@dataclass(frozen=True)
class PossibleAnswer(Answer):
    """Whether the episode is possible, and how far (m) a body gets from where it would be by the laws of physics."""

    kind: ClassVar[QuestionKind] = "possible"
    value: str
    apart: float


class Possible(Kind[PossibleAnswer]):
    """The answer compares the episode with the same one without violations."""

    countable = True
    watched = True

    def answer(self, asking: QuestionContext) -> PossibleAnswer:
        """Return the answer for the time until the last picture."""
        return _answer(asking, asking.run)

    def words(self, asking: QuestionContext, answer: PossibleAnswer) -> str:
        """Return `possible` or `impossible`."""
        return answer.value

    def change_under_nudge(self, asking: QuestionContext, answer: PossibleAnswer, nudged: Run, by: float) -> str:
        """Return the other answer, or ''. The episode without violations is nudged alike."""
        now = _answer(asking, nudged)
        if now.value == answer.value:
            return ""
        return f"{answer.value} becomes {now.value} when free bodies are displaced by {by * 1000:g} mm"

    def options(self, asking: QuestionContext, answer: PossibleAnswer, slot: AnswerSlot) -> tuple[Option, ...]:
        """Return both options. Raises Reject if no picture shows the violation."""
        if answer.value == IMPOSSIBLE:
            _require_visible_violation(asking)
        return tuple(
            Option("truth" if _OPTIONS[i] == answer.value else "label", _OPTIONS[i], text=_OPTIONS[i])
            for i in slot.order(_OPTIONS.index(answer.value), len(_OPTIONS))
        )

    def picked(self, mine: PossibleAnswer, other: PossibleAnswer) -> str | None:
        """Return the option of the other engine."""
        return other.value

    def agree(self, a: PossibleAnswer, b: PossibleAnswer) -> bool:
        """Whether both engines give the same answer."""
        return a.value == b.value

    def remedy(self, sort: str) -> str:
        """Return the remedy: a violation with a clear effect, or with none."""
        return "let the violation change much, or nothing at all"


def _answer(asking: QuestionContext, run: Run) -> PossibleAnswer:
    lawful = lawful_run(asking, run)
    until = max(time for _, time in asking.views)
    apart = run.distance(lawful, until)
    same = apart <= MIN_MOTION and all(
        _looks(run.scene, time) == _looks(lawful.scene, time) for time in _changes(run.scene, until)
    )
    return PossibleAnswer(POSSIBLE if same else IMPOSSIBLE, apart)


def lawful_run(asking: QuestionContext, run: Run) -> Run:
    """Return the episode without the actions that break the laws of physics. Raises Reject if the engine fails."""
    things = asking.values.spec.things
    unlawful = {t.name for t in things if t.kind == "action" and not t.of and t.verb in VIOLATIONS}
    scene = replace(run.scene, actions=tuple(a for a in run.scene.actions if a.name not in unlawful))
    try:
        trace = asking.pair.traces.trace(scene)
    except WmsError as error:
        raise Reject("unstable", f"without violations: {error.portable}") from None
    return Run(run.values, scene, trace, lambda change: lawful_run(asking, run.under(change)))


def _changes(scene: Scene, until: float) -> Iterable[float]:
    """Yield the times (s) at which the appearance may change, up to a time."""
    return sorted({until, *(action.start for action in scene.actions if action.start <= until)})


def _looks(scene: Scene, time: float) -> tuple[object, ...]:
    """Return which geoms of every body are visible, and their colours."""
    bodies = appearance_at(scene, time).bodies
    return tuple((body.name, *((geom.visible, geom.surface.color) for geom in body.geoms)) for body in bodies)


def _require_visible_violation(asking: QuestionContext) -> None:
    lawful = lawful_run(asking, asking.run)
    shares = [
        different_share(
            asking.observed.picture(camera, time).rgb,
            lawful.draw(camera, time, asking.pair).rgb,
        )
        for camera, time in asking.views
    ]
    if max(shares) < MIN_DIFFERENT_SHARE:
        detail = f"no picture shows the violation: {max(shares):.3%} of one differs from what is possible"
        raise Reject("alike", detail)
