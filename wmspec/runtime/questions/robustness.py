"""Whether an answer holds when every free body begins a little aside: a question about chaos has no answer."""

from __future__ import annotations

from collections.abc import Iterator

from wmspec.core.diagnostics import GraphicsError, WmsError
from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.runtime.questions.kinds import KINDS
from wmspec.runtime.questions.model import Answer, Reject
from wmspec.runtime.questions.question_context import Asking
from wmspec.runtime.questions.runs import Run, free, nudged

#: Unless the spec says how far: by 0.5 mm, once, where something free moves. A spec's own distance is tried twice.
NUDGE, NUDGES, NUDGES_SAID = 0.0005, 1, 2


def stable(asking: Asking, answer: Answer, key: tuple[object, ...]) -> None:
    """Raise Reject if the answer does not hold after a nudge, in a direction that depends on `key`."""
    for by, run in _nudges(asking, key):
        try:
            why = KINDS[answer.kind].disturbed(asking, answer, run, by)
        except GraphicsError:
            raise
        except WmsError as error:
            raise Reject("unstable", f"set aside by {by * 1000:g} mm: {error}") from None
        if why:
            raise Reject("unstable", why)


def _nudges(asking: Asking, key: tuple[object, ...]) -> Iterator[tuple[float, Run]]:
    """How far (m) everything free is set aside, and what happens then."""
    run, distance = asking.run, asking.question.stable
    loose = set(free(run.scene))
    if not (loose & run.movers() if distance is None else loose):
        return
    by = NUDGE if distance is None else evaluate(distance, asking.values)
    for k in range(NUDGES if distance is None else NUDGES_SAID):
        yield by, nudged(run, by, (*key, k), asking.pair)
