"""Figures of accuracy: averages, dimensions, comparisons."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes

from wmspec.eval.report.compare import Comparison
from wmspec.eval.report.figures.style import (
    GREY,
    INK,
    PALE,
    SvgFigure,
    color,
    draw_interval,
    format_percent_axis,
    label_rows,
    note_at_right,
    panels,
    signed_points,
    to_svg,
)
from wmspec.eval.report.replies import PEOPLE
from wmspec.eval.report.report import Report
from wmspec.eval.report.tables import Table

#: Significance level of a difference.
SIGNIFICANCE = 0.05
#: Maximum number of systems with a panel each.
MAX_PANELS = 12


def averages(report: Report) -> Iterator[SvgFigure]:
    """Yield every system's average, a panel for each kind of task."""
    high = 0.6 + 0.28 * len(report.systems)
    figure, axes = panels(len(report.tables), 4.6, high, 3)
    for ax, table in zip(axes, report.tables, strict=True):
        _averages(ax, table, report.systems)
    reading = (
        "A dot is a system's average, the mean over dimensions of the mean of their tasks; its line is the 95 % "
        "interval. The dashed line is chance."
    )
    yield to_svg(figure, "averages", "Average accuracy", reading)


def _averages(ax: Axes, table: Table, systems: tuple[str, ...]) -> None:
    by_system = {line.system: line.average for line in table.lines}
    ax.set_title(table.kind)
    ax.axvline(table.chance.average.value, color=GREY, linestyle=(0, (4, 3)), linewidth=1)
    for y, system in enumerate(systems):
        estimate = by_system[system]
        if np.isnan(estimate.value):
            continue
        draw_interval(ax, estimate, y, color(system, systems))
        ax.plot(estimate.value, y, "o", color=color(system, systems), markersize=6, clip_on=False)
        note_at_right(ax, y, f"{estimate.value:.0%}")
    label_rows(ax, systems)
    format_percent_axis(ax)


def dimensions(report: Report) -> Iterator[SvgFigure]:
    """Yield every system's accuracy by dimension, a panel each, perception above prediction, with people."""
    rows = [(t, d) for t in report.tables for d in t.dimensions]
    shown = [s for s in report.systems if s != PEOPLE][:MAX_PANELS]
    if len(rows) < 2 or not shown:
        return
    figure, axes = panels(len(shown), 3.2, 0.55 + 0.26 * len(rows), 3, sharey=True)
    kinds = [t.kind for t in report.tables]
    tones = dict(zip(kinds, ("#4477AA", "#CC6644", "#888888"), strict=False))
    for ax, system in zip(axes, shown, strict=True):
        ax.set_title(system)
        for y, (table, dimension) in enumerate(rows):
            by_system = {line.system: line.dimensions.get(dimension) for line in (*table.lines, table.chance)}
            mine = by_system[system]
            if mine is not None:
                ax.barh(y, mine.value, height=0.62, color=tones.get(table.kind, GREY))
                if mine.low is not None and mine.high is not None:
                    ax.plot([mine.low, mine.high], [y, y], color=INK, linewidth=1.1)
            for other, style in (
                (PEOPLE, {"color": INK, "linewidth": 2.4}),
                ("chance", {"color": INK, "linestyle": ":"}),
            ):
                value = by_system.get(other)
                if value is not None and not np.isnan(value.value):
                    ax.plot([value.value] * 2, [y - 0.38, y + 0.38], **style)
        label_rows(ax, [f"{d} ({t.kind})" for t, d in rows])
        format_percent_axis(ax)
    reading = (
        "A bar is the accuracy in a dimension, its thin line the 95 % interval; the dotted mark is chance"
        f"{', the thick black mark people' if PEOPLE in report.systems else ''}. "
        "Long bars in perception and short ones in prediction mean that a system perceives but does not predict."
    )
    more = f" The {MAX_PANELS} best systems are shown." if len(report.systems) > MAX_PANELS + 1 else ""
    yield to_svg(figure, "dimensions", "Perception and prediction by dimension", reading + more)


def comparisons(report: Report) -> Iterator[SvgFigure]:
    """Yield a matrix of pairwise differences."""
    kinds = list(dict.fromkeys(c.kind for c in report.comparisons))
    if not kinds or len(report.systems) > 24:
        return
    side = 1.9 + 0.42 * len(report.systems)
    figure, axes = panels(len(kinds), side, side, 2)
    for ax, kind in zip(axes, kinds, strict=True):
        _comparisons(ax, kind, [c for c in report.comparisons if c.kind == kind], report.systems)
    reading = (
        "A square is the difference in points between the systems of its row and column, on the questions that both "
        "answered: blue is better, red is worse. Bold numbers are significant (p < 0.05 after Holm, errors robust to "
        "control groups)."
    )
    yield to_svg(figure, "comparisons", "Pairwise comparisons", reading)


def _comparisons(ax: Axes, kind: str, pairs: list[Comparison], systems: tuple[str, ...]) -> None:
    index = {s: i for i, s in enumerate(systems)}
    gaps = np.full((len(systems), len(systems)), np.nan)
    for pair in pairs:
        i, j = index[pair.first], index[pair.second]
        gaps[i, j], gaps[j, i] = pair.difference.value, -pair.difference.value
        sure = pair.corrected is not None and pair.corrected < SIGNIFICANCE
        for row, column in ((i, j), (j, i)):
            gap = gaps[row, column]
            ink = "white" if abs(gap) > 0.28 else INK
            label = signed_points(gap, 0)
            ax.text(
                column, row, label, ha="center", va="center", fontsize=8, color=ink,
                weight="bold" if sure else "normal", alpha=1 if sure else 0.45,
            )  # fmt: skip
    ax.imshow(gaps, cmap="RdBu", vmin=-0.45, vmax=0.45)
    ax.set_title(kind)
    ax.set_xticks(range(len(systems)), systems, rotation=45, ha="right", rotation_mode="anchor")
    ax.set_yticks(range(len(systems)), systems)
    ax.set_facecolor(PALE)
    ax.tick_params(length=0)
    ax.spines[:].set_visible(False)
