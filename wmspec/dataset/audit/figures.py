"""Figures of the audit report, as SVG elements that the page draws in its own colours."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from wmspec.dataset.audit.model import Counts, Probe, Spread, Test
from wmspec.dataset.audit.probes import verdict

#: The width of a figure, the width of its row labels, and the height of a row (px).
WIDTH, WORDS, LINE = 720, 210, 24


@dataclass(frozen=True)
class Mark:
    """An SVG element: tag, class, attributes, text, and tooltip."""

    tag: str
    kind: str
    at: dict[str, str]
    text: str = ""
    meaning: str = ""


@dataclass(frozen=True)
class Figure:
    """SVG elements with a text description, `height` px high; the legend lists class and name of each kind of mark."""

    title: str
    marks: tuple[Mark, ...]
    height: int
    legend: tuple[tuple[str, str], ...] = ()
    width: int = WIDTH


def probes(shown: Sequence[Probe]) -> Figure:
    """Return a figure of accuracies with their intervals and chance levels."""
    parts = []
    for i, probe in enumerate(shown):
        y = LINE * i + LINE / 2
        kind = verdict(probe)
        parts += [
            _line("chance", _x(probe.chance), y - LINE / 2, _x(probe.chance), y + LINE / 2),
            _text(probe.sees, WORDS - 12, y, "end"),
            _line(f"whisker {kind}", _x(probe.low), y, _x(probe.high), y),
            _mark("circle", f"dot {kind}", cx=_x(probe.accuracy), cy=y, r=4.5),
            _text(f"{probe.accuracy:.0%}", WIDTH - 4, y, "end"),
        ]
    parts += [_text(f"{v:.0%}", _x(v), LINE * len(shown) + 12, "middle", "tick") for v in (0, 0.25, 0.5, 0.75, 1)]
    each = "; ".join(f"{p.sees}: {p.accuracy:.0%} ({p.low:.0%} to {p.high:.0%})" for p in shown)
    return _figure(f"What small classifiers get right, with chance as a line. {each}", parts, LINE * len(shown) + 24)


def _x(share: float) -> float:
    return WORDS + (WIDTH - WORDS - 60) * share


def rejected(counts: Sequence[Counts]) -> Figure:
    """Return a figure with the shares of every task's questions that were kept, and rejected by reason."""
    reasons = sorted({reason for c in counts for reason in c.rejected})
    parts = []
    for i, count in enumerate(counts):
        y, left = LINE * i, float(WORDS)
        parts.append(_text(count.task, WORDS - 12, y + LINE / 2, "end"))
        shares = [("kept", count.kept), *((r, count.rejected.get(r, 0)) for r in reasons)]
        for name, number in shares:
            wide = (WIDTH - WORDS - 60) * number / max(1, count.questions)
            kind = "kept" if name == "kept" else f"lost{reasons.index(name) % 6}"
            parts.append(_rect(kind, left, y + 4, wide, LINE - 8, f"{count.task}: {number:,} {name}"))
            left += wide
        parts.append(_text(f"{count.kept / max(1, count.questions):.0%}", WIDTH - 4, y + LINE / 2, "end"))
    keys = [("kept", "kept"), *((f"lost{i % 6}", reason) for i, reason in enumerate(reasons))]
    return _figure("The share of questions kept, and rejected by reason", parts, LINE * len(counts), keys)


def shares(test: Test) -> Figure:
    """Return a figure of how often each value is true, or in the true position."""
    (counts,) = test.counts
    total, most = sum(counts), max(counts)
    parts = []
    for i, (name, number) in enumerate(zip(test.columns, counts, strict=True)):
        y = LINE * i
        wide = (WIDTH - WORDS - 60) * number / max(1, most)
        parts += [
            _text(name, WORDS - 12, y + LINE / 2, "end"),
            _rect("kept", WORDS, y + 4, wide, LINE - 8, f"{name}: {number:,} of {total:,}"),
            _text(f"{number:,}", WIDTH - 4, y + LINE / 2, "end"),
        ]
    return _figure(f"How often each {test.first} occurs", parts, LINE * len(counts))


def spread(values: Spread) -> Figure:
    """Return a box plot of a quantity: minimum, quartiles and maximum."""
    low, quarter, middle, three, high = values.quantiles
    unit = values.unit
    span = high - low or 1.0
    y = LINE / 2

    def at(value: float) -> float:
        return WORDS + (WIDTH - WORDS - 60) * (value - low) / span

    parts = [
        _text(values.name, WORDS - 12, y, "end"),
        _line("whisker holds", at(low), y, at(high), y),
        _rect("kept", at(quarter), 5, max(1.0, at(three) - at(quarter)), LINE - 10),
        _line("chance", at(middle), 2, at(middle), LINE - 2),
        _text(f"{low:.3g}", at(low), LINE + 8, "start", "tick"),
        _text(f"{high:.3g} {unit}", at(high), LINE + 8, "end", "tick"),
    ]
    return _figure(f"{values.name}: {low:.3g} to {high:.3g}, middle {middle:.3g} {unit}", parts, LINE + 18)


# ---------------------------------------------------------------- elements


def _figure(title: str, marks: Iterable[Mark], height: float, legend: Iterable[tuple[str, str]] = ()) -> Figure:
    return Figure(title, tuple(marks), round(height), tuple(legend))


def _text(text: str, x: float, y: float, anchor: str, kind: str = "label") -> Mark:
    shown = text if len(text) <= 30 else f"{text[:29]}…"
    return _mark("text", kind, shown, x=x, y=y, dy=".35em", text_anchor=anchor)


def _rect(kind: str, x: float, y: float, wide: float, high: float, meaning: str = "") -> Mark:
    return _mark("rect", kind, meaning=meaning, x=x, y=y, width=wide, height=high)


def _line(kind: str, x1: float, y1: float, x2: float, y2: float) -> Mark:
    return _mark("line", kind, x1=x1, y1=y1, x2=x2, y2=y2)


def _mark(tag: str, kind: str, text: str = "", meaning: str = "", **at: float | str) -> Mark:
    values = {k.replace("_", "-"): v if isinstance(v, str) else f"{v:.1f}" for k, v in at.items()}
    return Mark(tag, kind, values, text, meaning)
