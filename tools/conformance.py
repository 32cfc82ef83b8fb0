"""The score card of docs/conformance.md, from what `wmspec conform --json` printed.

python -m tools.conformance SCORES.json...
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from tools.reference import table

PAGE = Path(__file__).parent.parent / "docs/conformance.md"
START, STOP = "<!-- scores -->\n", "<!-- /scores -->\n"


def cell(score: dict[str, Any]) -> str:
    """What was measured, in bold where it is too far off."""
    if score["measured"] is None:
        return "—"
    text = f"{score['measured']:.4g}"
    return text if score["passed"] else f"**{text}**"


def card(scores: list[dict[str, Any]]) -> list[str]:
    """The table: a row for each measure, a column for each engine."""
    engines = list(dict.fromkeys(score["engine"] for score in scores))
    rows: dict[tuple[str, str], dict[str, dict[str, Any]]] = {}
    for score in scores:
        rows.setdefault((score["case"], score["measure"]), {})[score["engine"]] = score
    head = ("case", "what", "answer", "within", "unit", *engines)
    made = []
    for (case, what), row in rows.items():
        one = next(iter(row.values()))
        about = (f"`{case}`", what, f"{one['answer']:.4g}", f"{one['tolerance']:.3g}", one["unit"])
        made.append((*about, *(cell(row[engine]) if engine in row else "" for engine in engines)))
    passed = [sum(score["passed"] for score in scores if score["engine"] == engine) for engine in engines]
    total = ("", "within the tolerance", str(len(rows)), "", "", *map(str, passed))
    return list(table(head, iter([*made, total])))


def main() -> None:
    """Rewrite the page."""
    scores = [score for path in sys.argv[1:] for score in json.loads(Path(path).read_text())]
    before, start, rest = PAGE.read_text().partition(START)
    PAGE.write_text(before + start + "\n" + "\n".join(card(scores)) + "\n\n" + STOP + rest.partition(STOP)[2])


if __name__ == "__main__":
    main()
