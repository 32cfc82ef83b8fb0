"""Executes the cases of the distribution usdphysics-conformance in engines of wmspec."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from wmspec.core.diagnostics import WmsError
from wmspec.runtime.engines.registry import backend

if TYPE_CHECKING:
    from usdphysics_conformance import Case, Score, Trace


def score_engine(engine: str, cases: Iterable[Case], traces: Path | None = None) -> Iterator[Score]:
    """The scores of an engine, case by case; writes each trace to the folder `traces`, if given, as CASE.npz."""
    from usdphysics_conformance import ConformanceError, refused_scores, score_trace, write_refusal, write_trace

    for case in cases:
        path = traces / f"{case.name}.npz" if traces else None
        try:
            trace = execute_case(engine, case)
        except (WmsError, ConformanceError) as error:
            reason = str(error)
            if path:
                write_refusal(path, reason)
            yield from refused_scores(engine, case, reason)
            continue
        if path:
            write_trace(path, trace)
        yield from score_trace(engine, case, trace)


def execute_case(engine: str, case: Case) -> Trace:
    """The trace of a case in an engine.

    Raises WmsError where the engine refuses the stage or diverges, ConformanceError where its trace is incomplete.
    """
    from pxr import Usd

    from usdphysics_conformance import SAMPLE_RATE, make_trace
    from wmspec.sim.usd import read

    stage = Usd.Stage.CreateInMemory()
    stage.GetRootLayer().ImportFromString(case.stage)
    scene = replace(read(stage, strict=False), duration=case.seconds, rate=SAMPLE_RATE)
    trace = backend(engine).execute(scene)
    return make_trace(case, trace.bodies, vars(trace))
