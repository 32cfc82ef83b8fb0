"""The report as one page that opens anywhere: tables, figures, and how to read them."""

from __future__ import annotations

import base64
import math

import pandas as pd

from wmspec.dataset.build.webpage import webpage
from wmspec.eval.report.figures.style import Drawn
from wmspec.eval.report.frames import DELTA, percent
from wmspec.eval.report.intervals import Estimate
from wmspec.eval.report.items import LEAST_SYSTEMS
from wmspec.eval.report.replies import BASELINES, PEOPLE
from wmspec.eval.report.report import Report
from wmspec.eval.report.tables import Table

#: Tables as a paper prints them: caption and cells by name.
Wide = dict[str, tuple[str, pd.DataFrame]]

#: What each section of the page is called.
TITLES = {
    "results": "Results",
    "compared": "Compared",
    "choices": "How they choose",
    "analyses": "What they see, and what they foresee",
    "items": "The questions",
}


#: The tables of a section that are folded away, for who needs the numbers.
TABLES_OF = {"choices": ("pairs",), "analyses": ("filtered", "thresholds", "entanglement")}


def page(report: Report, figures: dict[str, tuple[Drawn, ...]], wide: Wide) -> str:
    """The page: HTML with its style and figures inside, the same for the same report."""
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
        titles=TITLES,
        figures=figures,
        accounts_shown=sorted(report.accounts, key=lambda a: order.index(a.system)),
        tables_of=TABLES_OF,
        wide={name: (caption.replace(DELTA, "Δ"), frame) for name, (caption, frame) in wide.items()},
        least_systems=LEAST_SYSTEMS,
        percent=percent,
        picture=_picture,
        shade=_shade,
    )


def _picture(svg: str) -> str:
    return f"data:image/svg+xml;base64,{base64.b64encode(svg.encode()).decode()}"


def _shade(estimate: Estimate, chance: Estimate | None) -> str:
    """The colour of a cell: from chance (white) to all right (blue) or all wrong (red)."""
    guess = 0.0 if chance is None or math.isnan(chance.value) else chance.value
    above = (estimate.value - guess) / (1 - guess) if estimate.value >= guess else (estimate.value - guess) / guess
    tone = "0, 114, 178" if above >= 0 else "213, 94, 0"
    return f"rgba({tone}, {min(1, abs(above)) * 0.45:.2f})"


def summary(report: Report) -> list[str]:
    """What matters most, in sentences."""
    return [sentence for table in report.tables if (sentence := _summed_up(table))]


def _summed_up(table: Table) -> str:
    models = [line for line in table.lines if line.system not in (PEOPLE, *BASELINES)]
    if not models:
        return f"{table.kind.capitalize()}: only baselines and people have answered."
    best = models[0]
    people = next((line for line in table.lines if line.system == PEOPLE), None)
    text = f"{table.kind.capitalize()}: {best.system} is right most often, {_with_interval(best.average)}"
    text += f"; people are in {percent(people.average.value)} %" if people else ""
    chance = table.chance.average.value
    return text + (f". Guessing yields {percent(chance)} %." if not math.isnan(chance) else ".")


def _with_interval(estimate: Estimate) -> str:
    text = f"in {percent(estimate.value)} %"
    return text + (f" (95 % interval {percent(estimate.low)} to {percent(estimate.high)})" if estimate.sure else "")


def warnings(report: Report) -> list[str]:
    """What a reader must know before believing the numbers."""
    sentences = []
    failed = sum(a.failed for a in report.accounts)
    if failed:
        sentences.append(f"{failed:,} requests never got a reply. They are left out; evaluate again to fill them in.")
    lost = [a for a in report.accounts if a.replies and (a.unparsed + a.refused) / a.replies > 0.05]
    if lost:
        names = ", ".join(f"{a.system} ({(a.unparsed + a.refused) / a.replies:.0%})" for a in lost)
        sentences.append(f"Many replies have no answer in them, and are wrong here: {names}.")
    if report.narrow:
        names = ", ".join(report.narrow[:6]) + (f" and {len(report.narrow) - 6} more" if len(report.narrow) > 6 else "")
        sentences.append(
            f"{names}: these tasks have fewer than five control groups, so their intervals are over instances, and "
            "say nothing of other draws of what was the same in a group."
        )
    if not report.dataset:
        sentences.append(
            "Without --dataset there are no analyses of factors, differences, pairs and counterfactuals, and "
            "questions about what is seen count among the predictions."
        )
    return sentences
