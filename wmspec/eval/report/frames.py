"""Tables of a report: long ones for programs (CSV), wide ones for papers (LaTeX)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import asdict
from typing import Any

import pandas as pd

from wmspec.eval.report.entanglement import Entanglement
from wmspec.eval.report.intervals import Estimate
from wmspec.eval.report.report import Report
from wmspec.eval.report.tables import Table


def long_tables(report: Report) -> dict[str, pd.DataFrame]:
    """Return every non-empty analysis by name, one row a number. Estimates become four columns."""
    parts: dict[str, Iterable[Any]] = {
        "replies": report.accounts,
        "comparisons": report.comparisons,
        "films": report.films,
        "pairs": report.pairs,
        "whole_groups": report.whole_groups,
        "flips": report.flips,
        "positions": report.positions,
        "mistakes": report.mistaken,
        "preferences": report.preferences,
        "seen": report.seen,
        "entanglement": report.entanglement,
        "curves": report.curves,
        "detections": report.detections,
        "filtered": report.filtered,
        "missed": report.missed,
        "items": report.items.items if report.items else (),
        "abilities": report.items.abilities if report.items else (),
        "short_forms": report.items.forms if report.items else (),
        "short_form": [{"id": name, "counts": n} for name, n in report.items.short] if report.items else (),
    }
    made = {table.kind: pd.DataFrame(list(map(_flat, _accuracies(table)))) for table in report.tables}
    made |= {
        name: pd.DataFrame([_flat(p if isinstance(p, dict) else asdict(p)) for p in part])
        for name, part in parts.items()
    }
    return {name: frame for name, frame in made.items() if len(frame)}


def _accuracies(table: Table) -> Iterable[dict[str, Any]]:
    for line in (*table.lines, table.chance):
        for column in table.columns:
            yield {"system": line.system, **asdict(column), "accuracy": asdict(line.tasks[column.task])}
        for dimension, value in line.dimensions.items():
            yield {"system": line.system, "task": "", "dimension": dimension, "accuracy": asdict(value)}
        whole = {"system": line.system, "task": "", "dimension": "", "accuracy": asdict(line.average)}
        yield whole | {"answered only": line.parsed}


def _flat(row: dict[str, Any]) -> dict[str, Any]:
    """Return a row with estimates as columns `gain`, `gain low`, ...; sequences are left to the JSON."""
    flat: dict[str, Any] = {}
    for key, value in row.items():
        if isinstance(value, dict) and "value" in value:
            flat[key] = value["value"]
            flat |= {f"{key} {part}": value[part] for part in ("low", "high", "questions")}
        elif not isinstance(value, tuple | list | dict):
            flat[key] = value
    return flat


def wide_tables(report: Report) -> dict[str, tuple[str, pd.DataFrame]]:
    """Return tables as in a paper, by name, each with its caption; numbers are formatted in percent."""
    made = {t.kind: (f"Accuracy (%) in tasks of {t.kind}.", accuracy_table(t)) for t in report.tables}
    if report.films:
        caption = "Clips of video models: what they show. Errors are in object widths."
        made["films"] = (caption, film_table(report))
    for name, caption, cells in _crossed(report):
        if any(text for *_, text in cells):
            made[name] = (caption, _pivot(cells, report.systems))
    return made


def _crossed(report: Report) -> Iterator[tuple[str, str, list[tuple[str, str, str]]]]:
    """Yield the name and caption of each table with a column for each system, and its cells: row, system, text."""
    yield (
        "pairs",
        "Pair accuracy (%): of two instances that differ in one factor and in their answers, both are right.",
        [(p.task, p.system, format_percent(p.both.value)) for p in report.pairs],
    )
    yield (
        "whole_groups",
        "Accuracy (%) on whole groups of possible and impossible episodes: all members are right.",
        [(g.task, g.system, format_percent(g.whole.value)) for g in report.whole_groups],
    )
    yield (
        "detections",
        'd′ in same/different questions, in brackets the criterion (positive: a bias to "same").',
        [
            (f"{d.task} {d.question}", d.system, f"{d.sensitivity.value:.2f} ({d.criterion.value:+.2f})")
            for d in report.detections
            if d.difference is None
        ],
    )
    yield (
        "seen",
        "Accuracy (%) on questions without and with levels that training never saw together.",
        [
            (f"{s.task or 'all'}: {part}", s.system, format_percent(value.value))
            for s in report.seen
            for part, value in (("seen", s.seen), ("unseen", s.unseen))
        ],
    )
    yield (
        "preferences",
        "Chosen when the system errs: share of errors that choose it, minus share in which it is true (points).",
        [(f"{p.task}: {p.dimension} {p.level}", p.system, _points_with_interval(p.bias)) for p in report.preferences],
    )
    yield (
        "filtered",
        "Gain Δ (points) in prediction where the episode was perceived rightly.",
        [(f"{f.task}, perceived by {f.by}", f.system, _signed_points(f.gain.value)) for f in report.filtered],
    )
    yield (
        "missed",
        "Gain Δ (points) in prediction where a companion question was answered wrongly.",
        [(f"{m.task}, {m.missed} missed", m.system, _signed_points(m.gain.value)) for m in report.missed],
    )
    yield (
        "entanglement",
        "s-RE (%), 95 % intervals, and in brackets the null band. *: answers depend on the factor.",
        [(f"{e.task}: {e.factor}{'*' if e.probed else ''}", e.system, _entangled(e)) for e in report.entanglement],
    )
    yield (
        "thresholds",
        "Thresholds, with 95 % intervals.",
        [(f"{c.task}: {c.quantity}", c.system, _threshold(c.threshold, c.low, c.high)) for c in report.curves],
    )


#: The rows of the table of clips: name, field, and whether it is a share.
_FILM_ROWS = (
    ("shows the true future (%)", "right", True),
    ("the nearest future is true (%)", "forced", True),
    ("follows the state (%)", "state", True),
    ("follows the action (%)", "action", True),
    ("shows the future of another state (%)", "sibling_state", True),
    ("shows the future of another action (%)", "sibling_action", True),
    ("shows the future of another state and action (%)", "sibling_both", True),
    ("shows none of the futures (%)", "none", True),
    ("is frozen (%)", "frozen", True),
    ("runs at another tempo (%)", "tempo", True),
    ("error over the way", "track_error", False),
    ("error over the way between engines", "track_floor", False),
    ("error at the end", "final_error", False),
    ("error at the end between engines", "final_floor", False),
    ("Physics-IQ, spatial", "piq_spatial", False),
    ("Physics-IQ, spatiotemporal", "piq_spatiotemporal", False),
    ("Physics-IQ, weighted spatial", "piq_weighted", False),
    ("Physics-IQ, squared error", "piq_mse", False),
    ("overlap of objects (mIoU)", "miou", False),
    ("background error (RMSE)", "background_rmse", False),
)


def _number(number: float | None) -> str:
    """Return a number with three decimals, or with two digits if it is small."""
    if number is None or math.isnan(number):
        return "–"
    return f"{number:.3f}" if number == 0 or abs(number) >= 0.01 else f"{number:.2g}"


def film_table(report: Report) -> pd.DataFrame:
    """Return the scores of clips over all tasks: a row for each figure, a column for each system."""
    table = {}
    for scores in (s for s in report.films if not s.task):
        values = [getattr(scores, field) for _, field, _ in _FILM_ROWS]
        numbers = [value.value if hasattr(value, "value") else value for value in values]
        table[scores.system] = [
            format_percent(number) if share else _number(number)
            for number, (_, _, share) in zip(numbers, _FILM_ROWS, strict=True)
        ]
    frame = pd.DataFrame(table, index=[name for name, _, _ in _FILM_ROWS])
    return frame.reindex(columns=[s for s in report.systems if s in frame.columns])


def accuracy_table(table: Table) -> pd.DataFrame:
    """Return the table of accuracies in percent: a row for each system, then chance; averages on the right."""
    heads = [("average", "", d) for d in ("all", *table.dimensions)]
    heads += [(c.dimension, c.letters, c.task) for c in table.columns]
    rows = {}
    for line in (*table.lines, table.chance):
        averages = [line.dimensions[d].value if d in line.dimensions else float("nan") for d in table.dimensions]
        values = [line.average.value, *averages, *(line.tasks[c.task].value for c in table.columns)]
        rows[line.system] = [format_percent(value) for value in values]
    return pd.DataFrame.from_dict(rows, orient="index", columns=pd.MultiIndex.from_tuples(heads))


def _pivot(cells: Iterable[tuple[str, str, str]], systems: tuple[str, ...]) -> pd.DataFrame:
    table = pd.DataFrame(list(cells), columns=["", "system", "value"])
    crossed = table.pivot_table(index="", columns="system", values="value", aggfunc="first").fillna("")
    return crossed.reindex(columns=[s for s in systems if s in crossed.columns])


# ---------------------------------------------------------------- numbers


def format_percent(share: float | None) -> str:
    """Return a share in percent with one decimal; a dash for None."""
    return "–" if share is None or math.isnan(share) else f"{100 * share:.1f}"


def _signed_points(share: float) -> str:
    return "–" if math.isnan(share) else f"{100 * share:+.1f}".replace("-", "−")


def _points_with_interval(estimate: Estimate) -> str:
    if estimate.low is None or estimate.high is None:
        return _signed_points(estimate.value)
    return f"{_signed_points(estimate.value)} [{_signed_points(estimate.low)}, {_signed_points(estimate.high)}]"


def _entangled(e: Entanglement) -> str:
    interval = "" if e.low is None else f" [{format_percent(e.low)}, {format_percent(e.high)}]"
    return f"{format_percent(e.value)}{interval} ({format_percent(e.least)}–{format_percent(e.bound)})"


def _threshold(value: float | None, low: float | None, high: float | None) -> str:
    if value is None and low is None and high is None:
        return ""
    middle = "–" if value is None else f"{value:.3g}"
    return f"{middle} [{'' if low is None else f'{low:.3g}'}, {'' if high is None else f'{high:.3g}'}]"
