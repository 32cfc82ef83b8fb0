"""What all figures share: colours that stay with a system, axes without clutter, and SVG without dates."""

from __future__ import annotations

import io
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wmspec.eval.report.intervals import Estimate
from wmspec.eval.report.replies import BASELINES, PEOPLE

#: Colours that people with colour vision deficiencies tell apart (Okabe and Ito, 2008), the yellow darkened for white
#: paper.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#B8A000", "#56B4E9", "#8C564B", "#7F7FBF")
INK, GREY, PALE = "#1a1c1e", "#6b727c", "#d9dde3"
#: So many systems are drawn as lines; more cannot be told apart.
MOST_LINES = len(COLORS)

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
class Drawn:
    """A figure: its file's name, its title, how it is read, and the SVG."""

    name: str
    title: str
    reading: str
    svg: str


def settings() -> AbstractContextManager[None]:
    """The context in which figures are made and drawn."""
    return mpl.rc_context({"figure.dpi": 100, **_SETTINGS})  # type: ignore[dict-item]


def drawn(figure: Figure, name: str, title: str, reading: str) -> Drawn:
    """A figure as SVG, without the date and the version that matplotlib would write."""
    out = io.StringIO()
    figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None}, bbox_inches="tight", pad_inches=0.1)
    return Drawn(name, title, reading, out.getvalue())


def color(system: str, systems: Sequence[str]) -> str:
    """A system's colour: people are black, what checks the pipeline is grey."""
    if system == PEOPLE:
        return INK
    models = [s for s in systems if s != PEOPLE and s not in BASELINES]
    return COLORS[models.index(system) % len(COLORS)] if system in models else "#a4abb5"


def lines(systems: Sequence[str]) -> tuple[str, ...]:
    """The systems that figures of lines show: people, and the best models, as many as can be told apart."""
    models = [s for s in systems if s != PEOPLE and s not in BASELINES]
    return (*models[:MOST_LINES], *(s for s in systems if s == PEOPLE))


def percents(axes: Axes, which: str = "x", least: float = 0, most: float = 1) -> None:
    """An axis of shares, in percent."""
    axis = axes.xaxis if which == "x" else axes.yaxis
    (axes.set_xlim if which == "x" else axes.set_ylim)(least, most)
    axis.set_major_formatter(mpl.ticker.PercentFormatter(1, decimals=0))
    axes.grid(axis="both" if which == "both" else which, color=PALE, linewidth=0.6)  # type: ignore[arg-type]
    axes.set_axisbelow(True)


def whisker(axes: Axes, estimate: Estimate, y: float, color: str) -> None:
    """The interval of an estimate as a line at a height."""
    if estimate.low is not None and estimate.high is not None:
        ends = [estimate.low, estimate.high]
        axes.plot(ends, [y, y], color=color, linewidth=2.2, solid_capstyle="round", clip_on=False)


def signed(share: float, decimals: int = 1) -> str:
    """A difference of shares in points, with its sign; 0 has none."""
    text = f"{100 * share:+.{decimals}f}".replace("-", "−")
    return text if any(digit in text for digit in "123456789") else text[1:]


def named(axes: Axes, names: Sequence[str]) -> None:
    """Names from top to bottom, one a row."""
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.tick_params(axis="y", length=0)


def panels(count: int, wide: float, high: float, across: int, **how: object) -> tuple[Figure, list[Axes]]:
    """A figure of so many panels, each so wide and high (inches), with the rest of the last row left empty."""
    across = min(across, count)
    down = -(-count // across)
    figure = Figure(figsize=(wide * across, high * down), layout="constrained")
    axes = list(figure.subplots(down, across, squeeze=False, **how).ravel())  # type: ignore[call-overload]
    for empty in axes[count:]:
        empty.set_visible(False)
    return figure, axes[:count]


def legend(figure: Figure, systems: Sequence[str], everyone: Sequence[str], across: int = 5) -> None:
    """Above all panels: whose colour is which."""
    handles = [
        mpl.lines.Line2D([], [], color=color(s, everyone), marker="o", markersize=5, linewidth=2, label=s)
        for s in systems
    ]
    figure.legend(handles=handles, loc="outside upper left", ncols=across, handlelength=1.6, columnspacing=1.4)
