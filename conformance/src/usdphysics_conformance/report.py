"""Scores as text for a terminal and as a score card in Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

Record = Mapping[str, Any]
"""A score as `Score.record` gives it, and as it is in JSON."""

#: The keys of a record that a report reads.
RECORD_KEYS = {"engine", "case", "measure", "answer", "tolerance", "unit", "measured", "passed", "refusal"}


def score_text(records: Iterable[Record]) -> str:
    """The scores for a terminal: a criterion a paragraph, an engine a line; the totals of the engines last."""
    records = list(records)
    lines = []
    for (case, description), row in _rows(records).items():
        first = next(iter(row.values()))
        expected = f"{first['answer']:.5g} ± {first['tolerance']:.3g} {first['unit']}".rstrip()
        lines.append(f"{case}: {description}, {expected}")
        for engine, score in row.items():
            lines.append(f"  {'ok' if score['passed'] else '--'}  {engine:<9} {_result(score)}")
    lines += [f"{engine}: {passed} of {total}" for engine, passed, total in _totals(records)]
    return "\n".join(lines)


def score_card(records: Iterable[Record]) -> str:
    """The scores as a Markdown table: a criterion a row, an engine a column; bold where out of tolerance."""
    records = list(records)
    engines = list(dict.fromkeys(record["engine"] for record in records))
    rows = _rows(records)
    head = ("case", "measured quantity", "exact answer", "tolerance", "unit", *engines)
    lines = []
    for (case, description), row in rows.items():
        first = next(iter(row.values()))
        about = (f"`{case}`", description, f"{first['answer']:.4g}", f"{first['tolerance']:.3g}", first["unit"])
        lines.append((*about, *(_cell(row[engine]) if engine in row else "" for engine in engines)))
    totals = (str(passed) for _, passed, _ in _totals(records))
    lines.append(("", "number of results within tolerance", str(len(rows)), "", "", *totals))
    table = [f"| {' | '.join(line)} |" for line in (head, *lines)]
    return "\n".join([table[0], f"|{'---|' * len(head)}", *table[1:]]) + "\n"


def _rows(records: Iterable[Record]) -> dict[tuple[str, str], dict[str, Record]]:
    rows: dict[tuple[str, str], dict[str, Record]] = {}
    for record in records:
        rows.setdefault((record["case"], record["measure"]), {})[record["engine"]] = record
    return rows


def _totals(records: list[Record]) -> Iterator[tuple[str, int, int]]:
    """The engines, and of each how many criteria it passes, and of how many."""
    for engine in dict.fromkeys(record["engine"] for record in records):
        passed = [record["passed"] for record in records if record["engine"] == engine]
        yield engine, sum(passed), len(passed)


def _result(score: Record) -> str:
    return score["refusal"] if score["measured"] is None else f"{score['measured']:.5g} {score['unit']}".rstrip()


def _cell(score: Record) -> str:
    if score["measured"] is None:
        return "—"
    text = f"{score['measured']:.4g}"
    return text if score["passed"] else f"**{text}**"
