"""The last section of docs/audit.md, from what `wmspec audit --json` printed of datasets of the catalogue.

python -m tools.audited FILE...

Tasks that are in none of the files keep their lines.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from tools.reference import table
from wmspec.dataset.audit.cases import task_of

PAGE = Path(__file__).parent.parent / "docs/audit.md"
MARK = "<!-- audited -->\n"
USAGE = "python -m tools.audited FILE...: give the files that `wmspec audit --json` wrote"
VERDICTS = {"holds": "pass", "unclear": "unknown", "fails": "**fail**"}
HEADS = ("task", "verdict", "questions", "groups", "best judged probe, above chance", "would have been found")

Record = dict[str, Any]


def audited(records: Sequence[Record], before: str) -> Iterator[str]:
    """The lines of the section, which said `before` what it says of other tasks."""
    rows = {cells[0]: cells for cells in map(cells_of, before.splitlines()) if cells[0].startswith("`")}
    rows |= {cells[0]: cells for cells in (row(line) for record in records for line in record["summaries"])}
    passed = sum(cells[1] == VERDICTS["holds"] for cells in rows.values())
    yield f"{passed} of {len(rows)} tasks pass.\n"
    yield from table(HEADS, (rows[task] for task in sorted(rows, key=lambda name: name.strip("`"))))
    anew = {line["task"] for record in records for line in record["summaries"]}
    wrong = [line for line in before.splitlines() if line.startswith("- `") and task_of(line.split("`")[1]) not in anew]
    wrong += [
        f"- `{f['task']}`, {f['check']}: {f['what']}"
        for record in records
        for f in record["findings"]
        if f["verdict"] == "fails"
    ]
    yield "What fails:\n" if wrong else "Nothing fails.\n"
    yield from sorted(wrong)


def cells_of(line: str) -> tuple[str, ...]:
    """What a line of a Markdown table says."""
    return tuple(cell.strip() for cell in line.strip("|").split("|"))


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
    told, mark, before = PAGE.read_text(encoding="utf-8").partition(MARK)
    PAGE.write_text(told + mark + "\n" + "\n".join(audited(records, before)).rstrip() + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
