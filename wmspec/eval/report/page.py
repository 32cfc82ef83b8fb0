"""The report as a self-contained page: tables, figures, and explanations."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

import pandas as pd

from wmspec.dataset.build.images import data_url
from wmspec.dataset.build.webpage import webpage
from wmspec.eval.report.figures.style import SvgFigure
from wmspec.eval.report.frames import format_percent
from wmspec.eval.report.intervals import Estimate
from wmspec.eval.report.items import MIN_SYSTEMS
from wmspec.eval.report.replies import BASELINES, PEOPLE
from wmspec.eval.report.report import Report
from wmspec.eval.report.tables import Table

#: Formatted tables: caption and cells by name.
Wide = dict[str, tuple[str, pd.DataFrame]]

#: Titles of the sections.
TITLES = {
    "results": "Results",
    "compared": "Comparisons",
    "choices": "Choices",
    "analyses": "Perception and prediction",
    "items": "Questions",
}


#: Collapsed tables of each section.
TABLES_OF = {
    "choices": ("films", "pairs", "whole_groups", "preferences", "seen"),
    "analyses": ("detections", "filtered", "missed", "thresholds", "entanglement"),
}


def page(
    report: Report,
    figures: dict[str, tuple[SvgFigure, ...]],
    wide: Wide,
    strips: Mapping[str, bytes] = MappingProxyType({}),
) -> str:
    """Return the page: HTML with style and figures inside; deterministic. `strips` are film strips (PNG) by system."""
    order = (*report.systems, *(a.system for a in report.accounts))
    return webpage(
        "wmspec.eval.report",
        shaded=True,
        title=f"Report{f' on {report.dataset}' if report.dataset else ''}",
        report=report,
        models=sum(system != PEOPLE for system in report.systems),
        replies=sum(a.replies for a in report.accounts),
        summary=summary(report),
        warnings=warnings(report),
        lost=lost_answers(report),
        titles=TITLES,
        figures=figures,
        strips={name: data_url("image/png", png) for name, png in strips.items()},
        accounts_shown=sorted(report.accounts, key=lambda a: order.index(a.system)),
        tables_of=TABLES_OF,
        wide=wide,
        least_systems=MIN_SYSTEMS,
        percent=format_percent,
        picture=lambda svg: data_url("image/svg+xml", svg.encode()),
        shade=_shade,
    )


def _shade(estimate: Estimate, chance: Estimate | None) -> str:
    """Return the colour of a cell: chance is white, all right blue, all wrong red."""
    guess = 0.0 if chance is None or math.isnan(chance.value) else chance.value
    above = (estimate.value - guess) / (1 - guess) if estimate.value >= guess else (estimate.value - guess) / guess
    tone = "0, 114, 178" if above >= 0 else "213, 94, 0"
    return f"rgba({tone}, {min(1, abs(above)) * 0.45:.2f})"


def summary(report: Report) -> list[str]:
    """Return the main results, in sentences."""
    return [sentence for table in report.tables if (sentence := _summary_sentence(table))]


def _summary_sentence(table: Table) -> str:
    models = [line for line in table.lines if line.system not in (PEOPLE, *BASELINES)]
    if not models:
        return f"{table.kind.capitalize()}: only baselines and people have answered."
    best = models[0]
    people = next((line for line in table.lines if line.system == PEOPLE), None)
    text = f"{table.kind.capitalize()}: {best.system} is right most often, {_with_interval(best.average)}"
    text += f"; people are in {format_percent(people.average.value)} %" if people else ""
    chance = table.chance.average.value
    return text + (f". Guessing yields {format_percent(chance)} %." if not math.isnan(chance) else ".")


def _with_interval(estimate: Estimate) -> str:
    text = f"in {format_percent(estimate.value)} %"
    return text + (
        f" (95 % interval {format_percent(estimate.low)} to {format_percent(estimate.high)})" if estimate.sure else ""
    )


def lost_answers(report: Report) -> list[str]:
    """Return the causes of questions without an answer, by system."""
    return [f"{account.system}: {cause}" for account in report.accounts for cause in account.causes]


def warnings(report: Report) -> list[str]:
    """Return caveats for the interpretation of the numbers."""
    sentences = []
    failed = sum(a.error for a in report.accounts)
    if failed:
        sentences.append(f"{failed:,} requests have no reply and count as wrong; evaluate again to retry them.")
    lost = [a for a in report.accounts if a.replies and 1 - a.answered / a.replies > 0.05]
    if lost:
        names = ", ".join(f"{a.system} ({1 - a.answered / a.replies:.0%})" for a in lost)
        sentences.append(f"Many questions have no answer and count as wrong: {names}.")
    if report.narrow:
        names = ", ".join(report.narrow[:6]) + (f" and {len(report.narrow) - 6} more" if len(report.narrow) > 6 else "")
        sentences.append(
            f"{names}: these tasks have fewer than five control groups, so their intervals are over instances and "
            "do not cover variation between groups."
        )
    if not report.dataset:
        sentences.append(
            "Without --dataset there are no analyses of factors, differences, pairs and counterfactuals, and "
            "companion questions count among the predictions."
        )
    return sentences
