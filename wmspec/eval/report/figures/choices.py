"""Figures of choices: pair accuracy, option position, option order, and wrong outcomes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from wmspec.eval.report.choices import OTHER_KIND, SEVERAL_KINDS
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
    systems_as_lines,
    to_svg,
)
from wmspec.eval.report.report import Report


def pairs(report: Report) -> Iterator[SvgFigure]:
    """Yield pair accuracy beside single accuracy, as a mean over tasks."""
    tasks = sorted({p.task for p in report.pairs})
    if not tasks:
        return
    mean = {
        s: np.mean([(p.single, p.both.value, p.chance) for p in report.pairs if p.system == s], axis=0)
        for s in report.systems
        if any(p.system == s for p in report.pairs)
    }
    figure, (ax,) = panels(1, 6.4, 0.7 + 0.28 * len(mean), 1)
    for y, (system, (single, both, chance)) in enumerate(mean.items()):
        ax.plot([both, single], [y, y], color=PALE, linewidth=4, solid_capstyle="round", zorder=1)
        ax.plot(
            single, y, "o", color="white", markeredgecolor=color(system, report.systems), markersize=7, clip_on=False
        )
        ax.plot(both, y, "o", color=color(system, report.systems), markersize=7, clip_on=False)
        ax.plot([chance] * 2, [y - 0.35, y + 0.35], color=GREY, linestyle=":")
    label_rows(ax, list(mean))
    format_percent_axis(ax)
    reading = (
        "Two instances that differ in one factor and have different answers count only if both are right. The empty "
        "dot is the accuracy on single questions, the full one on pairs, the dotted mark chance on pairs. "
        "A large gap between the dots means that answers do not depend on the difference. "
        f"Mean over {len(tasks)} {'task' if len(tasks) == 1 else 'tasks'}."
    )
    yield to_svg(figure, "pairs", "Pair accuracy", reading)


def flips(report: Report) -> Iterator[SvgFigure]:
    """Yield how often another order of the options changes the answer."""
    whole = [f for s in report.systems for f in report.flips if f.system == s and not f.task]
    if not whole:
        return
    figure, (ax,) = panels(1, 6.4, 0.7 + 0.28 * len(whole), 1)
    for y, flip in enumerate(whole):
        ax.barh(y, flip.flips.value, height=0.6, color=color(flip.system, report.systems))
        draw_interval(ax, flip.flips, y, INK)
        note_at_right(ax, y, f"right in all orders: {flip.always:.0%}")
    label_rows(ax, [f.system for f in whole])
    format_percent_axis(ax)
    reading = (
        "The same question is asked with its options in several orders. A bar is the share of pairs of orders that get "
        "different answers, which is low for systems that know the answer."
    )
    yield to_svg(figure, "flips", "Dependence on option order", reading)


def positions(report: Report) -> Iterator[SvgFigure]:
    """Yield accuracy by the position of the true option."""
    counts = sorted({p.options for p in report.positions})
    shown = [s for s in systems_as_lines(report.systems) if any(p.system == s for p in report.positions)]
    if not counts or not shown:
        return
    figure, axes = panels(len(counts), 3.1, 2.9, 3, sharey=True)
    for ax, count in zip(axes, counts, strict=True):
        ax.set_title(f"{count} options")
        ax.axhline(1 / count, color=GREY, linestyle=(0, (4, 3)), linewidth=1)
        for system in shown:
            mine = sorted(
                (p for p in report.positions if (p.system, p.options) == (system, count)), key=lambda p: p.place
            )
            ax.plot(
                [p.place for p in mine], [p.accuracy.value for p in mine], "-o", color=color(system, report.systems),
                linewidth=1.8, markersize=4.5, clip_on=False,
            )  # fmt: skip
        ax.set_xticks(range(count), [_letter(i) for i in range(count)])
        ax.set_xlim(-0.3, count - 0.7)
        ax.set_xlabel("place of the true option")
        format_percent_axis(ax, "y")
    legend(figure, shown, report.systems)
    reading = (
        "Accuracy where the true option is shown first, second, and so on; dashed is chance. A level line means that "
        "position does not matter; a high start means a bias towards the first option."
    )
    yield to_svg(figure, "positions", "Accuracy by position of the true option", reading)


def _letter(place: int) -> str:
    return chr(ord("A") + place) if place < 26 else str(place + 1)


def mistakes(report: Report) -> Iterator[SvgFigure]:
    """Yield the kinds of change in the wrong outcomes chosen."""
    if not report.mistaken:
        return
    systems = [s for s in report.systems if any(m.system == s for m in report.mistaken)]
    tones = {"action": "#CC6644", "state": "#4477AA", SEVERAL_KINDS: "#885588", OTHER_KIND: "#a4abb5"}
    figure, (ax,) = panels(1, 6.8, 0.9 + 0.28 * len(systems), 1)
    shares = {s: _share(report, s) for s in systems}
    for y, system in enumerate(systems):
        left = 0.0
        for kind, tone in tones.items():
            chosen, _ = shares[system].get(kind, (0.0, 0.0))
            ax.barh(y, chosen, left=left, height=0.62, color=tone, label=kind if y == 0 else "_")
            if chosen > 0.08:
                ax.text(left + chosen / 2, y, f"{chosen:.0%}", ha="center", va="center", color="white", fontsize=8)
            left += chosen
        edge = 0.0
        for kind in tones:
            edge += shares[system].get(kind, (0.0, 0.0))[1]
            if 0 < edge < 0.999:
                ax.plot([edge] * 2, [y - 0.42, y + 0.42], color=INK, linewidth=1.6)
    label_rows(ax, systems)
    format_percent_axis(ax)
    there = [k for k in tones if any(m.changed == k for m in report.mistaken)]
    handles, names = ax.get_legend_handles_labels()
    kept = [(h, n) for h, n in zip(handles, names, strict=True) if n in there]
    figure.legend([h for h, _ in kept], [n for _, n in kept], loc="outside upper left", ncols=4)
    reading = (
        "Wrong predictions by the change in the chosen outcome: action or state. The black mark is the border "
        "expected from random choices. Orange beyond the mark means that the system confuses actions; blue beyond it, "
        "states."
    )
    yield to_svg(figure, "mistakes", "Choices among wrong outcomes", reading)


def _share(report: Report, system: str) -> dict[str, tuple[float, float]]:
    """Return the shares chosen and offered by kind of change, over all tasks, each mistake with equal weight."""
    mine = [m for m in report.mistaken if m.system == system]
    total = sum({m.task: m.mistakes for m in mine}.values())
    kinds = {m.changed for m in mine}
    return {
        k: (
            sum(m.chosen * m.mistakes for m in mine if m.changed == k) / total,
            sum(m.offered * m.mistakes for m in mine if m.changed == k) / total,
        )
        for k in kinds
    }
