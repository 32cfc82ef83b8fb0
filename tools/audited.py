"""The last section of docs/audit.md, from what `wmspec audit --json` printed of datasets of the catalogue.

python -m tools.audited FILE...
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from tools.reference import table

PAGE = Path(__file__).parent.parent / "docs/audit.md"
MARK = "<!-- audited -->\n"
USAGE = "python -m tools.audited FILE...: give the files that `wmspec audit --json` wrote"
VERDICTS = {"holds": "pass", "unclear": "unknown", "fails": "**fail**"}
HEADS = ("task", "verdict", "questions", "groups", "best judged probe, above chance", "would have been found")

Record = dict[str, Any]


def audited(records: Sequence[Record]) -> Iterator[str]:
    """The lines of the section."""
    lines = sorted((line for record in records for line in record["summaries"]), key=lambda line: line["task"])
    passed = sum(line["verdict"] == "holds" for line in lines)
    yield f"{passed} of {len(lines)} tasks pass.\n"
    yield from table(HEADS, map(row, lines))
    wrong = [finding for record in records for finding in record["findings"] if finding["verdict"] == "fails"]
    yield "What fails:\n" if wrong else "Nothing fails.\n"
    yield from (f"- `{f['task']}`, {f['check']}: {f['what']}" for f in sorted(wrong, key=lambda f: str(f["task"])))


def row(line: Record) -> tuple[str, ...]:
    """A task as its first page has it."""
    why = f" ({', '.join(line['why'])})" if line["why"] else ""
    best = f"{100 * line['above']:.0f} points, {line['best']}" if line["above"] is not None else "–"
    least = (
        "–"
        if line["least"] is None
        else "more than 30 points"
        if line["least"] == 1
        else f"{100 * line['least']:.0f} points"
    )
    return (
        f"`{line['task']}`",
        VERDICTS[line["verdict"]] + why,
        str(line["questions"]),
        str(line["groups"]),
        best,
        least,
    )


def main() -> None:
    """Rewrite the section."""
    records = [json.loads(Path(name).read_text(encoding="utf-8")) for name in sys.argv[1:]]
    if not records:
        sys.exit(USAGE)
    told, mark, _ = PAGE.read_text(encoding="utf-8").partition(MARK)
    PAGE.write_text(told + mark + "\n" + "\n".join(audited(records)).rstrip() + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
