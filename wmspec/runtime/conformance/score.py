"""How far engines are off: every case in an engine of wmspec's, or in the traces that another engine wrote."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.core.places import FilePlace
from wmspec.runtime.conformance.case import RATE, Case, Measure, Run, Track

Runner = Callable[[Case], Run]
"""What has an engine execute a case. Raises WmsError where the engine refuses it or loses it."""


@dataclass(frozen=True)
class Score:
    """What an engine makes of a measure: what it measured, or why it did not."""

    engine: str
    case: str
    measure: Measure
    measured: float | None
    refusal: str = ""

    @property
    def error(self) -> float | None:
        """By how much it is off, in the unit of the measure."""
        return None if self.measured is None else abs(self.measured - self.measure.answer)

    @property
    def passed(self) -> bool:
        """Whether it is within the tolerance."""
        return self.error is not None and self.error <= self.measure.tolerance

    def record(self) -> dict[str, object]:
        """The score as plain values, for JSON."""
        m = self.measure
        about = {"measure": m.what, "answer": float(m.answer), "tolerance": m.tolerance, "unit": m.unit}
        got = {"measured": self.measured, "error": self.error, "passed": self.passed, "refusal": self.refusal}
        return {"engine": self.engine, "case": self.case, **about, **got, "formula": m.formula, "source": m.source}


@cache
def cases() -> dict[str, Case]:
    """All cases by their names."""
    from wmspec.runtime.conformance import contacts, impacts, joints, mechanisms

    return {case.name: case for part in (contacts, impacts, joints, mechanisms) for case in part.cases()}


def chosen(names: Iterable[str]) -> tuple[Case, ...]:
    """The cases of these names; all without names. Raises WmsError for one that there is not."""
    known = cases()
    for name in names:
        if name not in known:
            raise WmsError(f"there is no case `{name}`; {suggestion(name, known)}".rstrip("; "))
    return tuple(known[name] for name in (tuple(names) or known))


def scores(engine: str, runner: Runner, wanted: Iterable[Case]) -> Iterator[Score]:
    """The scores of an engine, case by case."""
    for case in wanted:
        try:
            run = runner(case)
        except WmsError as error:
            yield from (Score(engine, case.name, measure, None, str(error.diagnostics[0])) for measure in case.measures)
            continue
        for measure in case.measures:
            number = float(measure.of(run))
            lost = "" if isfinite(number) else "what is measured did not happen"
            yield Score(engine, case.name, measure, None if lost else number, lost)


def by_backend(engine: str) -> Runner:
    """What executes cases in a backend of wmspec's, its own or one that an entry point brings."""
    from wmspec.runtime.engines.registry import backend

    known = backend(engine)

    def execute(case: Case) -> Run:
        from pxr import Usd

        from wmspec.sim.usd import read

        stage = Usd.Stage.CreateInMemory()
        stage.GetRootLayer().ImportFromString(case.stage)
        scene = replace(read(stage, strict=False), duration=case.seconds, rate=RATE)
        trace = known.execute(scene)
        return {name: Track(*(getattr(trace, what)[:, i] for what in _ARRAYS)) for i, name in enumerate(trace.bodies)}

    return execute


_ARRAYS = ("position", "orientation", "linear_velocity", "angular_velocity")


def by_traces(folder: Path) -> Runner:
    """What reads the traces in a folder, `CASE.npz` each, as docs/conformance.md says."""

    def load(case: Case) -> Run:
        path = folder / f"{case.name}.npz"
        if not path.is_file():
            raise WmsError("there is no trace of it", FilePlace(str(path)))
        try:
            with np.load(path, allow_pickle=False) as file:
                arrays: dict[str, Any] = dict(file)
            if "refusal" in arrays:
                raise WmsError(str(arrays["refusal"]), FilePlace(str(path)))
            names = [str(body).rpartition("/")[2] for body in arrays["bodies"]]
            tracks = [np.asarray(arrays[what], float) for what in _ARRAYS]
        except (KeyError, OSError, ValueError) as error:
            raise WmsError(f"is no trace of a case: {error}", FilePlace(str(path))) from None
        expected = round(case.seconds * RATE) + 1
        for track, width in zip(tracks, (3, 4, 3, 3), strict=True):
            if track.shape != (expected, len(names), width) or not np.isfinite(track).all():
                reason = f"an array is {track.shape}, expected ({expected}, {len(names)}, {width}) finite numbers"
                raise WmsError(reason, FilePlace(str(path)))
        return {name: Track(*(track[:, i] for track in tracks)) for i, name in enumerate(names)}

    return load
