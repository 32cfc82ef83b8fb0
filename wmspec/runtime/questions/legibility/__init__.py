"""Legibility: whether a person can see what decides the answer, measured on what is drawn."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from wmspec.lang.check.expressions.measured import is_measured, moments
from wmspec.runtime.questions.kinds import KINDS
from wmspec.runtime.questions.kinds.pictures import PictureAnswer
from wmspec.runtime.questions.legibility.bounds import BOUNDS, ratio
from wmspec.runtime.questions.legibility.color_vision import color_name_measures
from wmspec.runtime.questions.legibility.labels import DecisiveMeasures, least_by_name
from wmspec.runtime.questions.legibility.motion import is_drawn_moving, motion_measures, moves
from wmspec.runtime.questions.legibility.options import option_measures
from wmspec.runtime.questions.model import Answer, Legibility, Option, Reject, VisibleObject
from wmspec.runtime.questions.observed import MIN_MOTION
from wmspec.runtime.questions.question_context import QuestionContext

#: s: an episode that ends later than this after the last shown picture has an end that is not shown.
_MOMENT = 1e-6


def legibility(
    asking: QuestionContext,
    answer: Answer,
    options: Sequence[Option],
    pictures: Sequence[Sequence[VisibleObject]],
) -> tuple[Legibility, ...]:
    """Return the applicable measures of a question, each in its worst case.

    `pictures` are the visible objects of every shown picture.
    """
    return least_by_name(_measures(asking, answer, options, pictures))


def require_legible(measured: Sequence[Legibility]) -> None:
    """Raise Reject if a measure is not within its bound."""
    faults = [each for each in measured if ratio(each) < 1]
    if faults:
        raise Reject("illegible", "; ".join(map(_sentence, faults)))


def _sentence(fault: Legibility) -> str:
    limit = "most" if BOUNDS[fault.name].at_most else "least"
    required = f"{fault.bound:g} {fault.unit}".strip()
    of = f" of {fault.of}" if fault.of else ""
    return f"`{fault.name}`{of} is {fault.value:.3g} and must be at {limit} {required} ({BOUNDS[fault.name].meaning})"


def _measures(
    asking: QuestionContext,
    answer: Answer,
    options: Sequence[Option],
    pictures: Sequence[Sequence[VisibleObject]],
) -> Iterator[Legibility]:
    observed = asking.observed
    if isinstance(answer, PictureAnswer):
        yield from motion_measures(observed, _visible_movers(asking, _decisive_movers(asking, answer)))
        yield from option_measures(answer, KINDS["pictures"].option_images(asking, answer), asking.pair)
        return
    queried = list(dict.fromkeys(o.name for objects in pictures for o in objects if o.queried and o.color is not None))
    shown = float(observed.trace.time[-1]) <= observed.window[1] + _MOMENT
    spec, question = asking.values.spec, asking.question
    if moments(spec, question.answer) > 1 or (is_measured(spec, question.answer) and not shown):
        yield from motion_measures(
            observed, _visible_movers(asking, [name for name in queried if moves(observed, name)])
        )
    decisive = DecisiveMeasures(asking, shown)
    if queried:
        yield decisive.size(queried)
    yield from decisive.all()
    yield from color_name_measures(options, pictures)


def _visible_movers(asking: QuestionContext, names: Sequence[str]) -> list[str]:
    """Return the objects without those that may be hidden and that no two successive pictures show."""
    return [n for n in names if not asking.declared.declares(n) or is_drawn_moving(asking.observed, n)]


def _decisive_movers(asking: QuestionContext, answer: PictureAnswer) -> list[str]:
    """Return the objects that move while they are shown, and that the options show at different places."""
    objects = {thing.name for thing in asking.values.spec.things if thing.kind == "object"}
    movers = []
    for k, name in enumerate(answer.bodies):
        places = answer.outcomes[:, k, :3]
        gone = np.isnan(places).any(axis=1)
        differ = bool((np.linalg.norm(places - places[0], axis=1) > MIN_MOTION).any() or gone.any() != gone.all())
        if name in objects and differ and moves(asking.observed, name):
            movers.append(name)
    return movers
