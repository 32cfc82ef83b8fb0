"""What a report tells as tables: long ones for programs (CSV), wide ones for papers (LaTeX)."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict
from typing import Any

import pandas as pd

from wmspec.eval.report.report import Report
from wmspec.eval.report.tables import Table

#: How LaTeX writes a gain.
DELTA = r"$\Delta$"


def long(report: Report) -> dict[str, pd.DataFrame]:
    """Every analysis that has something to tell, by name, a row for each number told. Estimates become four columns."""
    parts: dict[str, Iterable[Any]] = {
        "replies": report.accounts,
        "comparisons": report.comparisons,
        "pairs": report.pairs,
        "flips": report.flips,
        "positions": report.positions,
        "mistakes": report.mistaken,
        "entanglement": report.entanglement,
        "curves": report.curves,
        "filtered": report.filtered,
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
        yield whole | {"unparsed skipped": line.parsed}


def _flat(row: dict[str, Any]) -> dict[str, Any]:
    """A row in which estimates are columns, `gain`, `gain low`, ...; sequences are left to the JSON."""
    flat: dict[str, Any] = {}
    for key, value in row.items():
        if isinstance(value, dict) and "value" in value:
            flat[key] = value["value"]
            flat |= {f"{key} {part}": value[part] for part in ("low", "high", "questions")}
        elif not isinstance(value, tuple | list | dict):
            flat[key] = value
    return flat


def wide(report: Report) -> dict[str, tuple[str, pd.DataFrame]]:
    """Tables as a paper prints them, by name, each with its caption; numbers are written out, in percent."""
    made = {t.kind: (f"Accuracy (%) in tasks of {t.kind}.", accuracy(t)) for t in report.tables}
    if report.pairs:
        made["pairs"] = (
            "Pair accuracy (%): of two instances that differ in one factor and in their answers, both are right.",
            _crossed(((p.task, p.system, percent(p.both.value)) for p in report.pairs), report.systems),
        )
    if report.filtered:
        rows = ((f"{f.task}, perceived by {f.by}", f.system, _signed(f.gain.value)) for f in report.filtered)
        made["filtered"] = (
            f"Gain {DELTA} (points) in prediction where the episode was perceived rightly.",
            _crossed(rows, report.systems),
        )
    if report.entanglement:
        cells = (
            (f"{e.task}: {e.factor}", e.system, f"{percent(e.value)} ({percent(e.mean)})") for e in report.entanglement
        )
        made["entanglement"] = (
            "s-RE (%) by task and factor, in brackets when the levels are shuffled.",
            _crossed(cells, report.systems),
        )
    thresholds = [(f"{c.task}: {c.quantity}", c.system, _threshold(c.threshold, c.low, c.high)) for c in report.curves]
    if any(cell for *_, cell in thresholds):
        made["thresholds"] = ("Thresholds, with 95 % intervals.", _crossed(thresholds, report.systems))
    return made


def accuracy(table: Table) -> pd.DataFrame:
    """The table of accuracies in percent as it is printed: a row for each system, then chance; averages right."""
    heads = [("average", "", d) for d in ("all", *table.dimensions)]
    heads += [(c.dimension, c.letters, c.task) for c in table.columns]
    rows = {}
    for line in (*table.lines, table.chance):
        averages = [line.dimensions[d].value if d in line.dimensions else float("nan") for d in table.dimensions]
        values = [line.average.value, *averages, *(line.tasks[c.task].value for c in table.columns)]
        rows[line.system] = [percent(value) for value in values]
    return pd.DataFrame.from_dict(rows, orient="index", columns=pd.MultiIndex.from_tuples(heads))


def _crossed(cells: Iterable[tuple[str, str, str]], systems: tuple[str, ...]) -> pd.DataFrame:
    table = pd.DataFrame(list(cells), columns=["", "system", "value"])
    crossed = table.pivot_table(index="", columns="system", values="value", aggfunc="first").fillna("")
    return crossed.reindex(columns=[s for s in systems if s in crossed.columns])


def latex(caption: str, frame: pd.DataFrame) -> str:
    """A table in LaTeX, for the packages booktabs and multirow; what LaTeX would read as a command is escaped."""
    escaped = frame.rename(index=_escaped, columns=_escaped).map(_escaped)
    escaped.index.name = None
    escaped.columns.names = [None] * escaped.columns.nlevels
    written: str = escaped.to_latex(escape=False, caption=caption.replace("%", r"\%"), multicolumn_format="c")
    return written


def _escaped(text: str) -> str:
    return text.translate(_LATEX).replace(" · ", r" $\cdot$ ")


#: What LaTeX would read otherwise: whoever named a model must not write the paper.
_LATEX = str.maketrans(
    {c: f"\\{c}" for c in "_%&#${}"}
    | {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "–": "--", "−": "$-$"}
)


# ---------------------------------------------------------------- numbers


def percent(share: float | None) -> str:
    """A share in percent with a decimal; a dash for none."""
    return "–" if share is None or math.isnan(share) else f"{100 * share:.1f}"


def _signed(share: float) -> str:
    return "–" if math.isnan(share) else f"{100 * share:+.1f}".replace("-", "−")


def _threshold(value: float | None, low: float | None, high: float | None) -> str:
    if value is None and low is None and high is None:
        return ""
    middle = "–" if value is None else f"{value:.3g}"
    return f"{middle} [{'' if low is None else f'{low:.3g}'}, {'' if high is None else f'{high:.3g}'}]"
