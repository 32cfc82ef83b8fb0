"""Scores: what traces give for the criteria, against the answers of mechanics."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

from usdphysics_conformance.case import Case, ConformanceError, Criterion, Trace
from usdphysics_conformance.traces import read_trace


@dataclass(frozen=True)
class Score:
    """The result of an engine for one criterion: the number measured, or why there is none."""

    engine: str
    case: str
    criterion: Criterion
    measured: float | None
    refusal: str = ""

    @property
    def error(self) -> float | None:
        """The distance from the answer, in the unit of the criterion; None without a measured number."""
        return None if self.measured is None else abs(self.measured - self.criterion.answer)

    @property
    def passed(self) -> bool:
        """Whether the error is within the tolerance."""
        return self.error is not None and self.error <= self.criterion.tolerance

    def record(self) -> dict[str, object]:
        """The score as plain values, for JSON."""
        about = self.criterion.record()
        origin = {key: about.pop(key) for key in ("formula", "source")}
        result = {"measured": self.measured, "error": self.error, "passed": self.passed, "refusal": self.refusal}
        return {"engine": self.engine, "case": self.case, **about, **result, **origin}


def score_trace(engine: str, case: Case, trace: Trace) -> Iterator[Score]:
    """The scores of a trace, one for each criterion of the case."""
    for criterion in case.criteria:
        number = float(criterion.measure(trace))
        if isfinite(number):
            yield Score(engine, case.name, criterion, number)
        else:
            yield Score(engine, case.name, criterion, None, "what is measured did not happen")


def refused_scores(engine: str, case: Case, reason: str) -> Iterator[Score]:
    """The scores where there is no trace, one for each criterion of the case."""
    return (Score(engine, case.name, criterion, None, reason) for criterion in case.criteria)


def score_folder(engine: str, folder: Path, cases: Iterable[Case]) -> Iterator[Score]:
    """The scores of the traces `CASE.npz` in a folder. A missing or broken trace counts as failed, with the reason.

    Raises ConformanceError if there is no such folder.
    """
    if not folder.is_dir():
        raise ConformanceError(f"{folder}: there is no such folder of traces")
    for case in cases:
        try:
            trace = read_trace(case, folder / f"{case.name}.npz")
        except ConformanceError as error:
            yield from refused_scores(engine, case, str(error))
            continue
        yield from score_trace(engine, case, trace)
