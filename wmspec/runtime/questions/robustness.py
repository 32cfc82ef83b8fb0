"""Stability of answers when free bodies are displaced: chaotic outcomes have no answer."""

from __future__ import annotations

from collections.abc import Iterator

from wmspec.core.diagnostics import GraphicsError, WmsError
from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.runtime.questions.kinds import KINDS
from wmspec.runtime.questions.model import Answer, Reject
from wmspec.runtime.questions.question_context import QuestionContext
from wmspec.runtime.questions.runs import Run, free_bodies, nudged

#: Defaults: 0.5 mm, once, where a free body moves. A distance from the spec is tried twice.
DEFAULT_NUDGE, DEFAULT_NUDGES, SPEC_NUDGES = 0.0005, 1, 2


def require_stable(asking: QuestionContext, answer: Answer, key: tuple[object, ...]) -> None:
    """Raise Reject if the answer changes under a nudge, in a direction drawn from `key`."""
    for by, run in _nudges(asking, key):
        try:
            why = KINDS[answer.kind].change_under_nudge(asking, answer, run, by)
        except GraphicsError:
            raise
        except WmsError as error:
            raise Reject("unstable", f"displaced by {by * 1000:g} mm: {error.portable}") from None
        if why:
            raise Reject("unstable", why)


def _nudges(asking: QuestionContext, key: tuple[object, ...]) -> Iterator[tuple[float, Run]]:
    """Yield displacements (m) of free bodies and the resulting runs."""
    run, distance = asking.run, asking.question.stable
    if not any(_may_vary(each, distance is None) for each in (run, *asking.imagined)):
        return
    by = DEFAULT_NUDGE if distance is None else evaluate(distance, asking.values)
    for k in range(DEFAULT_NUDGES if distance is None else SPEC_NUDGES):
        yield by, nudged(run, by, (*key, k), asking.pair)


def _may_vary(run: Run, moving: bool) -> bool:
    """Whether a nudge may change a run: it has free bodies; with `moving`, one of them moves."""
    loose = set(free_bodies(run.scene))
    return bool(loose & run.movers() if moving else loose)
