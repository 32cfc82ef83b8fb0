"""Figures of how systems choose: in pairs, by place, in other orders, and which wrong outcome."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from wmspec.eval.report.choices import BOTH, OTHER
from wmspec.eval.report.figures.style import (
    GREY,
    INK,
    PALE,
    Drawn,
    color,
    drawn,
    legend,
    lines,
    named,
    panels,
    percents,
    whisker,
)
from wmspec.eval.report.report import Report


def pairs(report: Report) -> Iterator[Drawn]:
    """Pair accuracy beside plain accuracy, as a mean over tasks."""
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
    named(ax, list(mean))
    percents(ax)
    reading = (
        "Two instances that differ in one factor and have different answers count only if both are right. The empty "
        "dot is the accuracy on single questions, the full one on pairs, the dotted mark what guessing yields on "
        "pairs. A long way between the dots means answers that do not follow what differs. "
        f"Mean over {len(tasks)} {'task' if len(tasks) == 1 else 'tasks'}."
    )
    yield drawn(figure, "pairs", "Right on both of a pair", reading)


def flips(report: Report) -> Iterator[Drawn]:
    """How often another order of the options gets another answer."""
    whole = [f for s in report.systems for f in report.flips if f.system == s and not f.task]
    if not whole:
        return
    figure, (ax,) = panels(1, 6.4, 0.7 + 0.28 * len(whole), 1)
    for y, flip in enumerate(whole):
        ax.barh(y, flip.flips.value, height=0.6, color=color(flip.system, report.systems))
        whisker(ax, flip.flips, y, INK)
        ax.annotate(
            f"right in all orders: {flip.always:.0%}",
            (1.02, y),
            xycoords=("axes fraction", "data"),
            va="center",
            color=GREY,
        )
    named(ax, [f.system for f in whole])
    percents(ax)
    reading = (
        "The same question is asked with its options in several orders. A bar is the share of pairs of orders that get "
        "different answers: whoever knows the answer has a short one."
    )
    yield drawn(figure, "flips", "The answer changes with the order of the options", reading)


def positions(report: Report) -> Iterator[Drawn]:
    """Accuracy by the place of the true option."""
    counts = sorted({p.options for p in report.positions})
    shown = [s for s in lines(report.systems) if any(p.system == s for p in report.positions)]
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
        percents(ax, "y")
    legend(figure, shown, report.systems)
    reading = (
        "Accuracy where the true option is shown first, second, and so on; dashed is chance. A level line means that "
        "the place does not matter; a high beginning means a liking for the first option."
    )
    yield drawn(figure, "positions", "Accuracy by the place of the truth", reading)


def _letter(place: int) -> str:
    return chr(ord("A") + place) if place < 26 else str(place + 1)


def mistakes(report: Report) -> Iterator[Drawn]:
    """What was otherwise in the wrong outcomes that were chosen."""
    if not report.mistaken:
        return
    systems = [s for s in report.systems if any(m.system == s for m in report.mistaken)]
    tones = {"action": "#CC6644", "state": "#4477AA", BOTH: "#885588", OTHER: "#a4abb5"}
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
    named(ax, systems)
    percents(ax)
    there = [k for k in tones if any(m.changed == k for m in report.mistaken)]
    handles, names = ax.get_legend_handles_labels()
    kept = [(h, n) for h, n in zip(handles, names, strict=True) if n in there]
    figure.legend([h for h, _ in kept], [n for _, n in kept], loc="outside upper left", ncols=4)
    reading = (
        "Of wrong predictions: the share that took an outcome in which another action was done, or another state was "
        "there. The black mark is where the border would be if the wrong options were drawn by lot. Orange beyond "
        "the mark means that the system confuses what was done; blue beyond it, what was there."
    )
    yield drawn(figure, "mistakes", "Which wrong outcome is taken for the true one", reading)


def _share(report: Report, system: str) -> dict[str, tuple[float, float]]:
    """Over all tasks, each mistake counting once: the shares chosen and offered, by what was changed."""
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
