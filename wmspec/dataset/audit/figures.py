"""The figures of the report, as SVG that takes its colours from the page."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from wmspec.dataset.audit.model import Counts, Probe, Spread, Test
from wmspec.dataset.audit.probes import verdict

#: The width of a figure, of the words at its left, and the height of a line (px).
WIDTH, WORDS, LINE = 720, 210, 24


def probes(shown: Sequence[Probe]) -> str:
    """Accuracies with their intervals; a line at what chance yields each."""
    parts = []
    for i, probe in enumerate(shown):
        y = LINE * i + LINE / 2
        kind = verdict(probe)
        parts += [
            _line("chance", _x(probe.chance), y - LINE / 2, _x(probe.chance), y + LINE / 2),
            _text(probe.sees, WORDS - 12, y, "end"),
            _line(f"whisker {kind}", _x(probe.low), y, _x(probe.high), y),
            f'<circle class="dot {kind}" cx="{_x(probe.accuracy):.1f}" cy="{y:.1f}" r="4.5"/>',
            _text(f"{probe.accuracy:.0%}", WIDTH - 4, y, "end"),
        ]
    parts += [_text(f"{v:.0%}", _x(v), LINE * len(shown) + 12, "middle", "tick") for v in (0, 0.25, 0.5, 0.75, 1)]
    each = "; ".join(f"{p.sees}: {p.accuracy:.0%} ({p.low:.0%} to {p.high:.0%})" for p in shown)
    return _figure(f"What small classifiers get right, with chance as a line. {each}", parts, LINE * len(shown) + 24)


def _x(share: float) -> float:
    return WORDS + (WIDTH - WORDS - 60) * share


def rejected(counts: Sequence[Counts]) -> str:
    """Of every task's questions, the share that was kept and the shares that were rejected, by reason."""
    reasons = sorted({reason for c in counts for reason in c.rejected})
    parts = []
    for i, count in enumerate(counts):
        y, left = LINE * i, float(WORDS)
        parts.append(_text(count.task, WORDS - 12, y + LINE / 2, "end"))
        shares = [("kept", count.kept), *((r, count.rejected.get(r, 0)) for r in reasons)]
        for name, number in shares:
            wide = (WIDTH - WORDS - 60) * number / max(1, count.asked)
            kind = "kept" if name == "kept" else f"lost{reasons.index(name) % 6}"
            parts.append(_rect(kind, left, y + 4, wide, LINE - 8, f"{count.task}: {number:,} {name}"))
            left += wide
        parts.append(_text(f"{count.kept / max(1, count.asked):.0%}", WIDTH - 4, y + LINE / 2, "end"))
    return _figure("The share of questions kept, and rejected by reason", parts, LINE * len(counts)) + _legend(reasons)


def _legend(reasons: Sequence[str]) -> str:
    keys = [("kept", "kept"), *((f"lost{i % 6}", reason) for i, reason in enumerate(reasons))]
    shown = " ".join(f'<span class="key"><i class="{kind}"></i>{escape(name)}</span>' for kind, name in keys)
    return f'<p class="legend">{shown}</p>'


def shares(test: Test) -> str:
    """How often each value is the true one, or in the true place."""
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


def spread(values: Spread) -> str:
    """A quantity's least, quarter, middle, three quarters and most."""
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


# ---------------------------------------------------------------- pieces


def _figure(title: str, parts: Iterable[str], height: float) -> str:
    return f'<svg viewBox="0 0 {WIDTH} {height:.0f}" role="img" aria-label="{escape(title)}">{"".join(parts)}</svg>'


def _text(text: str, x: float, y: float, anchor: str, kind: str = "label") -> str:
    shown = text if len(text) <= 30 else f"{text[:29]}…"
    return f'<text class="{kind}" x="{x:.1f}" y="{y:.1f}" dy=".35em" text-anchor="{anchor}">{escape(shown)}</text>'


def _rect(kind: str, x: float, y: float, wide: float, high: float, meaning: str = "") -> str:
    title = f"<title>{escape(meaning)}</title>" if meaning else ""
    return f'<rect class="{kind}" x="{x:.1f}" y="{y:.1f}" width="{wide:.1f}" height="{high:.1f}">{title}</rect>'


def _line(kind: str, x1: float, y1: float, x2: float, y2: float) -> str:
    return f'<line class="{kind}" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"/>'
