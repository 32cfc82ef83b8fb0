"""Whether an answer holds when every free body begins a little aside: a question about chaos has no answer."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmspec.ask.gates import apart
from wmspec.ask.measure import Measured
from wmspec.ask.model import Reject
from wmspec.ask.options import same
from wmspec.ask.runs import EnginePair, Run, free, nudged
from wmspec.ask.views import View
from wmspec.check.evaluate import evaluate
from wmspec.check.ir import Question
from wmspec.diagnostics import GraphicsError, WmsError

#: Unless the spec says how far: by 0.5 mm, once, where something free moves. A spec's own distance is tried twice.
NUDGE, NUDGES, NUDGES_SAID = 0.0005, 1, 2
#: An outcome may move by this share of its distance to the nearest other option.
MOST_MOVED = 1 / 3


def stable(
    question: Question, run: Run, answer: Any, looks: Sequence[View], key: tuple[object, ...], crew: EnginePair
) -> None:
    """Raise Reject if a measured answer is another one after a nudge."""
    for by, other in _nudges(question, run, key, crew):
        try:
            now = evaluate(question.answer, Measured(other.values, other.observed(looks, crew)))
        except GraphicsError:
            raise
        except WmsError as error:
            raise Reject("unstable", f"set aside by {by * 1000:g} mm: {error}") from None
        if not _same(question, answer, now, run):
            raise Reject("unstable", f"{answer} becomes {now} when everything free is set aside by {by * 1000:g} mm")


def stable_picture(
    question: Question,
    run: Run,
    time: float,
    names: Sequence[str],
    outcomes: NDArray[np.float64],
    key: tuple[object, ...],
    crew: EnginePair,
) -> None:
    """Raise Reject if after a nudge the outcome (the first of `outcomes`) has moved far towards another option.

    Options that are nearer than the nudge itself differ in something else than places, such as a colour.
    """
    gaps = [apart(outcomes[0], other) for other in outcomes[1:]]
    for by, other in _nudges(question, run, key, crew):
        moved = apart(outcomes[0], other.poses(names, time))
        nearest = min((gap for gap in gaps if gap > by), default=np.inf)
        if moved > MOST_MOVED * nearest:
            raise Reject(
                "unstable",
                f"set aside by {by * 1000:g} mm it ends {moved * 100:.1f} cm from where it was, "
                f"and the nearest other option is {nearest * 100:.1f} cm away",
            )


def _nudges(question: Question, run: Run, key: tuple[object, ...], crew: EnginePair) -> Iterator[tuple[float, Run]]:
    said = question.stable is not None
    loose = set(free(run.scene))
    if not (loose if said else loose & run.movers()):
        return
    by = evaluate(question.stable, run.values) if question.stable is not None else NUDGE
    for k in range(NUDGES_SAID if said else NUDGES):
        yield by, nudged(run, by, (*key, k), crew)


def _same(question: Question, before: Any, after: Any, run: Run) -> bool:
    if isinstance(before, float) and question.within is not None:
        return bool(abs(before - after) <= evaluate(question.within, run.values))
    return same(before, after)
