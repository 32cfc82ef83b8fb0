"""Figures of stimulus differences, filtered prediction, and items."""

from __future__ import annotations

from collections.abc import Iterator

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes

from wmspec.eval.report.curves import Curve
from wmspec.eval.report.figures.style import (
    GREY,
    INK,
    PALE,
    SvgFigure,
    color,
    draw_interval,
    format_percent_axis,
    label_rows,
    legend,
    note_at_right,
    panels,
    signed_points,
    systems_as_lines,
    to_svg,
)
from wmspec.eval.report.filtered import OWN_PERCEPTION
from wmspec.eval.report.replies import PEOPLE
from wmspec.eval.report.report import Report

# ---------------------------------------------------------------- curves


def curves(report: Report) -> Iterator[SvgFigure]:
    """Yield accuracy against the stimulus difference, a panel for each question, with fitted curves."""
    shown = [s for s in systems_as_lines(report.systems) if any(c.system == s for c in report.curves)]
    keys = list(dict.fromkeys((c.task, c.question, c.quantity) for c in report.curves))
    if not keys or not shown:
        return
    figure, axes = panels(len(keys), 3.3, 2.7, 3)
    for ax, key in zip(axes, keys, strict=True):
        mine = [c for s in shown for c in report.curves if c.system == s and (c.task, c.question, c.quantity) == key]
        _curves(ax, mine, report.systems)
    legend(figure, shown, report.systems)
    reading = (
        "Accuracy against the stimulus difference. Dots are measurements, lines are logistic fits where accuracy "
        "depends on the difference. Marks on the lower edge are thresholds, half-way from guessing (dashed) to the "
        "maximum, with their 95 % intervals. A curve further left means finer discrimination."
    )
    yield to_svg(figure, "curves", "Thresholds of perceived differences", reading)


def _curves(ax: Axes, mine: list[Curve], systems: tuple[str, ...]) -> None:
    first = mine[0]
    ax.set_title(first.task + (f": {first.question}" if first.question else ""))
    if first.scale == "log":
        ax.set_xscale("log", base=2)
    shown = sorted({round(p[0], 3) for curve in mine for p in curve.points})
    ax.set_xticks(shown[:: -(-len(shown) // 6)])
    ax.xaxis.set_major_formatter(lambda x, _: f"{x:.3g}")
    ax.xaxis.set_minor_formatter(mpl.ticker.NullFormatter())
    ax.axhline(first.chance, color=GREY, linestyle=(0, (4, 3)), linewidth=1)
    for curve in mine:
        tone = color(curve.system, systems)
        x, y, _ = np.array(curve.points).T
        ax.plot(x, y, "o", color=tone, markersize=4, alpha=0.9)
        if curve.alpha is None or (curve.threshold is None and curve.low is None and curve.high is None):
            ax.plot(x, y, ":", color=tone, linewidth=1)
            continue
        along = np.geomspace(x.min(), x.max(), 80) if curve.scale == "log" else np.linspace(x.min(), x.max(), 80)
        ax.plot(along, curve.at(along), color=tone, linewidth=2.4 if curve.system == PEOPLE else 1.7)
        if curve.threshold is not None:
            low, high = (v if v is not None else edge for v, edge in ((curve.low, x.min()), (curve.high, x.max())))
            ax.plot([low, high], [0.02, 0.02], color=tone, linewidth=2, alpha=0.6, solid_capstyle="round")
            ax.plot(curve.threshold, 0.02, "^", color=tone, markersize=5)
    ax.set_xlabel(first.quantity + (f" ({first.unit})" if first.unit else ""), fontsize=8)
    format_percent_axis(ax, "y", 0, 1.03)


# ---------------------------------------------------------------- filtered prediction


def filtered(report: Report) -> Iterator[SvgFigure]:
    """Yield accuracy on all episodes, and on those perceived correctly: a panel for each task."""
    mine = [f for f in report.filtered if f.by == OWN_PERCEPTION and not np.isnan(f.perceived.value)]
    tasks = sorted({f.task for f in mine})
    if not tasks:
        return
    systems = [s for s in report.systems if any(f.system == s for f in mine)]
    figure, axes = panels(len(tasks), 4.6, 0.7 + 0.28 * len(systems), 2, sharey=True)
    for ax, task in zip(axes, tasks, strict=True):
        ax.set_title(task)
        for f in (f for f in mine if f.task == task):
            y, tone = systems.index(f.system), color(f.system, report.systems)
            draw_interval(ax, f.perceived, y, tone)
            ax.plot([f.everything.value, f.perceived.value], [y, y], color=PALE, linewidth=1)
            ax.plot(f.everything.value, y, "o", color="white", markeredgecolor=tone, markersize=7, clip_on=False)
            ax.plot(f.perceived.value, y, "o", color=tone, markersize=6, clip_on=False)
            sure = f.gain.low is not None and f.gain.high is not None and f.gain.low * f.gain.high > 0
            note_at_right(ax, y, signed_points(f.gain.value), **{"weight": "bold", "color": INK} if sure else {})
        label_rows(ax, systems)
        format_percent_axis(ax)
    reading = (
        "The empty dot is the accuracy on all predictions, the full one on those whose episode the system perceived "
        "correctly (with its 95 % interval). At the right: Δ in points, bold if its interval excludes 0. Where correct "
        "perception does not help, prediction fails, not perception."
    )
    yield to_svg(figure, "filtered", "Prediction given correct perception", reading)


# ---------------------------------------------------------------- items


def items(report: Report) -> Iterator[SvgFigure]:
    """Yield the difficulty of questions beside the ability of systems, and the error of short forms."""
    if report.items is None:
        return
    difficulty = [i.difficulty for i in report.items.items]
    figure, (ax,) = panels(1, 6.6, 0.9 + 0.25 * len(report.items.abilities) + 1.4, 1)
    low, high = (
        np.floor(min(difficulty) - 0.25),
        np.ceil(max(*difficulty, *(a.ability for a in report.items.abilities)) + 0.25),
    )
    low = min(low, np.floor(min(a.ability for a in report.items.abilities)))
    counts, edges = np.histogram(difficulty, np.linspace(low, high, 41))
    names = [a.system for a in sorted(report.items.abilities, key=lambda a: -a.ability)]
    ax.bar(
        edges[:-1], -5 * counts / counts.max(), np.diff(edges), bottom=len(names) + 4.8, align="edge", color="#b9c2cf"
    )  # fmt: skip
    for y, name in enumerate(names):
        ability = next(a.ability for a in report.items.abilities if a.system == name)
        ax.plot([ability, ability], [y, len(names) + 4.8], color=PALE, linewidth=1, zorder=0)
        ax.plot(ability, y, "o", color=color(name, report.systems), markersize=7)
        ax.text(ability, y, f"  {name}  ", va="center", ha="left" if ability < (low + high) / 2 else "right")
    ax.set_ylim(len(names) + 4.8, -0.8)
    ax.set_yticks([])
    ax.spines["left"].set_visible(False)
    ax.set_xlabel("easier · weaker  ←  standard deviations of ability  →  harder · stronger")
    reading = (
        "Below: difficulty of questions; above: ability of systems, on the same axis. A system answers half of the "
        "questions at its own position, beyond guessing. Without questions near a system, its ability is uncertain."
    )
    yield to_svg(figure, "items", "Difficulty and ability", reading)
    if len(report.items.forms) > 1:
        yield _forms(report)


def _forms(report: Report) -> SvgFigure:
    assert report.items is not None
    figure, (ax,) = panels(1, 4.6, 2.8, 1)
    size = [f.size for f in report.items.forms]
    ax.plot(size, [f.at_random for f in report.items.forms], "--o", color=GREY, markersize=4, label="drawn at random")
    ax.plot(size, [f.error for f in report.items.forms], "-o", color="#0072B2", label="chosen by task and difficulty")
    ax.set_xscale("log")
    ax.xaxis.set_minor_formatter(mpl.ticker.NullFormatter())
    ax.set_xticks(size, [str(s) for s in size])
    ax.set_xlabel("questions")
    format_percent_axis(ax, "y", 0, 1.15 * max(max(f.error, f.at_random) for f in report.items.forms))
    ax.legend()
    reading = (
        f"Error of the score on a short form, relative to all {len(report.items.items):,} questions (root mean square)."
    )
    return to_svg(figure, "short_form", "Size of a short form", reading)
