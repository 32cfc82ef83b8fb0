"""Shared style of figures: one colour for each system, plain axes, and SVG without dates."""

from __future__ import annotations

import io
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, Literal

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wmspec.eval.report.intervals import Estimate
from wmspec.eval.report.replies import BASELINES, PEOPLE

#: Colours for colour-vision deficiencies (Okabe and Ito, 2008), with a darker yellow for white paper.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#B8A000", "#56B4E9", "#8C564B", "#7F7FBF")
INK, GREY, PALE = "#1a1c1e", "#6b727c", "#d9dde3"
#: Maximum number of systems drawn as lines.
MAX_LINES = len(COLORS)

_SETTINGS = {
    "svg.hashsalt": "wmspec",
    "svg.fonttype": "path",
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": GREY,
    "axes.labelcolor": INK,
    "xtick.color": GREY,
    "ytick.color": GREY,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "text.color": INK,
    "legend.frameon": False,
}


@dataclass(frozen=True)
class SvgFigure:
    """A figure: file name, title, reading instructions, and SVG."""

    name: str
    title: str
    reading: str
    svg: str


def settings() -> AbstractContextManager[None]:
    """Return the context in which figures are created and drawn."""
    return mpl.rc_context({"figure.dpi": 100, **_SETTINGS})  # type: ignore[dict-item]


def to_svg(figure: Figure, name: str, title: str, reading: str) -> SvgFigure:
    """Return a figure as SVG, without matplotlib's date and version."""
    out = io.StringIO()
    figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None}, bbox_inches="tight", pad_inches=0.1)
    return SvgFigure(name, title, reading, out.getvalue())


def color(system: str, systems: Sequence[str]) -> str:
    """Return a system's colour: black for people, grey for baselines."""
    if system == PEOPLE:
        return INK
    models = [s for s in systems if s != PEOPLE and s not in BASELINES]
    return COLORS[models.index(system) % len(COLORS)] if system in models else "#a4abb5"


def systems_as_lines(systems: Sequence[str]) -> tuple[str, ...]:
    """Return the systems shown as lines: people, and as many of the best models as remain distinguishable."""
    models = [s for s in systems if s != PEOPLE and s not in BASELINES]
    return (*models[:MAX_LINES], *(s for s in systems if s == PEOPLE))


def format_percent_axis(axes: Axes, which: Literal["x", "y"] = "x", least: float = 0, most: float = 1) -> None:
    """Format an axis of shares in percent."""
    axis = axes.xaxis if which == "x" else axes.yaxis
    (axes.set_xlim if which == "x" else axes.set_ylim)(least, most)
    axis.set_major_formatter(mpl.ticker.PercentFormatter(1, decimals=0))
    axes.grid(axis=which, color=PALE, linewidth=0.6)
    axes.set_axisbelow(True)


def draw_interval(axes: Axes, estimate: Estimate, y: float, color: str) -> None:
    """Draw the interval of an estimate as a horizontal line."""
    if estimate.low is not None and estimate.high is not None:
        ends = [estimate.low, estimate.high]
        axes.plot(ends, [y, y], color=color, linewidth=2.2, solid_capstyle="round", clip_on=False)


def note_at_right(axes: Axes, y: float, text: str, **how: Any) -> None:
    """Write a text at the right of a row."""
    axes.annotate(text, (1.02, y), xycoords=("axes fraction", "data"), va="center", **{"color": GREY} | how)


def signed_points(share: float, decimals: int = 1) -> str:
    """Return a difference of shares in points, with its sign; 0 has none."""
    text = f"{100 * share:+.{decimals}f}".replace("-", "−")
    return text if any(digit in text for digit in "123456789") else text[1:]


def label_rows(axes: Axes, names: Sequence[str]) -> None:
    """Label rows from top to bottom."""
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.tick_params(axis="y", length=0)


def panels(count: int, wide: float, high: float, across: int, **how: object) -> tuple[Figure, list[Axes]]:
    """Return a figure of `count` panels, each `wide` by `high` (inches), with the rest of the last row empty."""
    across = min(across, count)
    down = -(-count // across)
    figure = Figure(figsize=(wide * across, high * down), layout="constrained")
    axes = list(figure.subplots(down, across, squeeze=False, **how).ravel())  # type: ignore[call-overload]
    for empty in axes[count:]:
        empty.set_visible(False)
    return figure, axes[:count]


def legend(figure: Figure, systems: Sequence[str], everyone: Sequence[str], across: int = 5) -> None:
    """Draw the legend of systems above all panels."""
    handles = [
        mpl.lines.Line2D([], [], color=color(s, everyone), marker="o", markersize=5, linewidth=2, label=s)
        for s in systems
    ]
    figure.legend(handles=handles, loc="outside upper left", ncols=across, handlelength=1.6, columnspacing=1.4)
