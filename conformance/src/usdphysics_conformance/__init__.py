"""Test cases with analytic answers for physics engines that read UsdPhysics.

A case is a stage of plain UsdPhysics with criteria: numbers that mechanics gives in closed form, each with a tolerance.
An engine executes the stage and writes a trace; the trace is scored against the criteria.
"""

from usdphysics_conformance.case import SAMPLE_RATE, Case, ConformanceError, Criterion, Motion, Trace
from usdphysics_conformance.cases import all_cases, select_cases
from usdphysics_conformance.report import score_card, score_text
from usdphysics_conformance.scoring import Score, refused_scores, score_folder, score_trace
from usdphysics_conformance.traces import make_trace, read_trace, write_refusal, write_trace
from usdphysics_conformance.write import write_cases

__version__ = "1.0.0"

__all__ = [
    "SAMPLE_RATE",
    "Case",
    "ConformanceError",
    "Criterion",
    "Motion",
    "Score",
    "Trace",
    "all_cases",
    "make_trace",
    "read_trace",
    "refused_scores",
    "score_card",
    "score_folder",
    "score_text",
    "score_trace",
    "select_cases",
    "write_cases",
    "write_refusal",
    "write_trace",
]
