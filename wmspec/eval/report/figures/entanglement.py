"""Figures of s-RE: tasks by dimension, models by dimension, and intervals beside the null band."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from wmspec.eval.report.entanglement import DIMENSIONS, Entanglement
from wmspec.eval.report.figures.style import (
    INK,
    PALE,
    SvgFigure,
    color,
    format_percent_axis,
    label_rows,
    legend,
    panels,
    systems_as_lines,
    to_svg,
)
from wmspec.eval.report.replies import BASELINES, PEOPLE
from wmspec.eval.report.report import Report

Grid = NDArray[np.float64]


def entanglement(report: Report) -> Iterator[SvgFigure]:
    """Yield s-RE of tasks by the paper's dimensions, measured and shuffled; then of each model, and with intervals."""
    models = [s for s in report.systems if s not in (*BASELINES, PEOPLE)]
    mine = [e for e in report.entanglement if e.system in models and e.dimension]
    if not mine:
        return
    tasks, columns = sorted({e.task for e in mine}), [d for d in DIMENSIONS if any(e.dimension == d for e in mine)]
    chosen = {(t, d): factor for t in tasks for d in columns if (factor := _most_entangled(mine, t, d))}
    value, shuffled = (_grid(chosen, tasks, columns, which) for which in ("value", "mean"))
    probed = np.array([[any(e.probed for e in chosen.get((t, d), ())) for d in columns] for t in tasks])
    figure, axes = panels(2, 1.6 + 0.75 * len(columns), 0.9 + 0.3 * len(tasks), 2, sharey=True)
    top = max(0.1, float(np.nanmax(value)))
    for ax, grid, title in zip(axes, (value, shuffled), ("measured", "when shuffled"), strict=True):
        _heat(ax, grid, tasks, columns, top, probed)
        ax.set_title(title)
    reading = (
        "s-RE: the mean relative change of accuracy when only this property of the objects changes; mean over "
        f"{len(models)} {'model' if len(models) == 1 else 'models'}. The right side is the same with shuffled levels, "
        "as expected by chance. Where the left square is no darker than the right one, nothing is entangled. If a "
        "task varies several such factors, the one with the largest value is shown. With *, the answer depends on the "
        "factor, so that accuracy may depend on it too."
    )
    yield to_svg(figure, "entanglement", "Does accuracy depend on irrelevant factors?", reading)
    yield from _by_model([e for e in mine if not e.probed], models, columns)
    yield from _bands(report, chosen, columns)


def _most_entangled(mine: list[Entanglement], task: str, dimension: str) -> list[Entanglement]:
    """Return the results of the factor with the largest excess s-RE; factors without influence on answers first."""
    factors: dict[tuple[str, str], list[Entanglement]] = {}
    for e in mine:
        if (e.task, e.dimension) == (task, dimension):
            factors.setdefault((e.question, e.factor), []).append(e)
    free = {key: found for key, found in factors.items() if not any(e.probed for e in found)} or factors
    if not free:
        return []
    return free[max(sorted(free), key=lambda f: np.mean([e.value - e.mean for e in free[f]]))]


def _grid(chosen: dict[tuple[str, str], list[Entanglement]], tasks: list[str], columns: list[str], which: str) -> Grid:
    """Return the mean over models for each task and dimension, NaN without a factor."""
    return np.array([
        [np.mean([getattr(e, which) for e in chosen[t, d]]) if (t, d) in chosen else np.nan for d in columns]
        for t in tasks
    ])  # fmt: skip


def _heat(
    ax: Axes, grid: Grid, rows: list[str], columns: list[str], top: float, marked: NDArray[np.bool_] | None = None
) -> None:
    ax.imshow(grid, cmap="OrRd", vmin=0, vmax=top, aspect="auto")
    ax.set_facecolor("#eef0f3")
    for (i, j), value in np.ndenumerate(grid):
        if not np.isnan(value):
            label = f"{100 * value:.0f}{'*' if marked is not None and marked[i, j] else ''}"
            ax.text(j, i, label, ha="center", va="center", color="white" if value > 0.6 * top else INK)
    ax.set_xticks(range(len(columns)), columns)
    ax.xaxis.tick_top()
    ax.set_yticks(range(len(rows)), rows)
    ax.tick_params(length=0)
    ax.spines[:].set_visible(False)


def _by_model(mine: list[Entanglement], models: list[str], columns: list[str]) -> Iterator[SvgFigure]:
    if not mine:
        return
    grid = np.array([
        [np.mean([e.value - e.mean for e in mine if (e.system, e.dimension) == (m, d)] or [np.nan]) for d in columns]
        for m in models
    ])  # fmt: skip
    figure, (ax,) = panels(1, 1.8 + 0.85 * len(columns), 0.8 + 0.3 * len(models), 1)
    _heat(ax, np.maximum(grid, 0), models, columns, max(0.05, float(np.nanmax(grid))))
    reading = "s-RE beyond what shuffling yields (points), mean over tasks and factors: 0 means independence."
    yield to_svg(figure, "entanglement_models", "Dependence of each model on irrelevant factors", reading)


def _bands(
    report: Report, chosen: dict[tuple[str, str], list[Entanglement]], columns: list[str]
) -> Iterator[SvgFigure]:
    """Yield s-RE with intervals on the scale of the null band, a panel for each dimension."""
    shown = [
        s for s in systems_as_lines(report.systems) if any(e.system == s for found in chosen.values() for e in found)
    ]
    rows = {d: [t for t, other in chosen if other == d] for d in columns}
    figure, axes = panels(len(columns), 3.6, 0.7 + 0.3 * max(map(len, rows.values())), 2)
    reach = max([e.high or e.value for found in chosen.values() for e in found if e.system in shown] or [0.1])
    for ax, dimension in zip(axes, columns, strict=True):
        ax.set_title(dimension)
        for y, task in enumerate(rows[dimension]):
            for e in (e for e in chosen[task, dimension] if e.system in shown):
                offset = y + 0.5 * (shown.index(e.system) / max(1, len(shown) - 1) - 0.5) * (len(shown) > 1)
                ax.plot([e.least, e.bound], [offset, offset], color=PALE, linewidth=4, solid_capstyle="butt", zorder=0)
                if e.low is not None and e.high is not None:
                    ax.plot([e.low, e.high], [offset, offset], color=color(e.system, report.systems), linewidth=1)
                face = "white" if e.probed else color(e.system, report.systems)
                tone = color(e.system, report.systems)
                ax.plot(e.value, offset, "o", color=face, markeredgecolor=tone, markersize=4)
        label_rows(ax, rows[dimension])
        format_percent_axis(ax, most=min(1.0, 1.05 * reach))
    legend(figure, shown, report.systems)
    reading = (
        "s-RE with its 95 % interval. The grey band is what shuffled levels yield in 90 % of cases: a dot to the right "
        "of its band depends on the factor. Empty dots are factors on which the answer depends."
    )
    yield to_svg(figure, "entanglement_bands", "s-RE and its null band", reading)
