"""All figures, in page order."""

from __future__ import annotations

from wmspec.eval.report.figures import accuracy, analyses, choices, entanglement
from wmspec.eval.report.figures.style import SvgFigure, settings
from wmspec.eval.report.report import Report

#: The figures of each section of the page.
SECTIONS = {
    "results": (accuracy.averages,),
    "compared": (accuracy.dimensions, accuracy.comparisons),
    "choices": (choices.pairs, choices.positions, choices.flips, choices.mistakes),
    "analyses": (analyses.filtered, analyses.curves, entanglement.entanglement),
    "items": (analyses.items,),
}


def figures(report: Report) -> dict[str, tuple[SvgFigure, ...]]:
    """Return the available figures of each section."""
    with settings():
        return {name: tuple(f for draw in draws for f in draw(report)) for name, draws in SECTIONS.items()}
