"""Writes a report: page, figures (in the order of the page), tables and JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from types import MappingProxyType
from typing import Any

from wmspec.core.safe_io import make_folders
from wmspec.dataset.build.files import with_remedies
from wmspec.eval.report.figures import accuracy, analyses, choices, entanglement
from wmspec.eval.report.figures.style import SvgFigure, settings
from wmspec.eval.report.frames import long_tables, wide_tables
from wmspec.eval.report.latex import accuracy_frame, latex_table
from wmspec.eval.report.page import page
from wmspec.eval.report.report import Report


def write(report: Report, folder: Path, strips: Mapping[str, bytes] = MappingProxyType({})) -> Path:
    """Write a report to a folder and return the page's path. Raises WmsError if it cannot be written.

    `strips` are film strips (PNG) by system.
    """
    drawn, printed = figures(report), wide_tables(report)
    content = {"report.json": text(report), "report.html": page(report, drawn, printed, strips)}
    content |= {f"figures/{f.name}.svg": f.svg for section in drawn.values() for f in section}
    content |= {
        f"tables/{name}.csv": frame.to_csv(index=False, lineterminator="\n")
        for name, frame in long_tables(report).items()
    }
    accuracies = {table.kind: accuracy_frame(table) for table in report.tables}
    content |= {
        f"tables/{name}.tex": latex_table(caption, accuracies.get(name, frame))
        for name, (caption, frame) in printed.items()
    }
    if "thresholds" in printed:
        content["tables/thresholds.csv"] = printed["thresholds"][1].to_csv(lineterminator="\n")
    for name, written in content.items():
        path = folder / name
        with with_remedies(path):
            make_folders(path.parent)
            path.write_text(written, encoding="utf-8")
    return folder / "report.html"


def text(report: Report) -> str:
    """Return the report as JSON; missing values are null."""
    return json.dumps(_json_values(asdict(report)), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _json_values(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _json_values(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_json_values(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


#: The figures of each section of the page.
SECTIONS = {
    "results": (accuracy.averages,),
    "compared": (accuracy.dimensions, accuracy.comparisons),
    "choices": (choices.pairs, choices.positions, choices.flips, choices.mistakes),
    "analyses": (analyses.filtered, analyses.curves, entanglement.entanglement),
    "items": (analyses.items,),
}


def figures(report: Report) -> dict[str, tuple[SvgFigure, ...]]:
    """Return the available figures of each section."""
    with settings():
        return {name: tuple(f for draw in draws for f in draw(report)) for name, draws in SECTIONS.items()}
