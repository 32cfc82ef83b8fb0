"""The last table of docs/crosscheck.md, from what `wmspec crosscheck --json FILE` wrote.

python -m tools.agreement FILE
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tools.reference import table

PAGE = Path(__file__).parent.parent / "docs/crosscheck.md"
MARK = "<!-- measured -->\n"
HEAD = ("task", "engines", "answers", "before gates", "within tolerance", "gap, median", "largest", "event")


def measured(record: dict[str, Any]) -> Iterator[str]:
    """The lines of the section."""
    engines = ", ".join(f"{name} {version}" for name, version in record["engines"].items())
    lines = record["summary"]
    good, total = (sum(line["before_gates"][k] for line in lines) for k in ("good", "all"))
    yield f"{len(record['instances'])} instances, seed {record['seed']}, with {engines}. Whatever the gates say,"
    yield f"{good} of {total} answers are the same in both engines of a pair: {good / total:.2%}.\n"
    yield from table(HEAD, map(row, lines))


def row(line: dict[str, Any]) -> tuple[str, ...]:
    """A task in a pair of engines."""
    shares = (f"{line[k]['good']}/{line[k]['all']}" for k in ("answers", "before_gates", "episodes"))
    gaps = (f"{line[k] * 100:.2f} cm" for k in ("median", "largest"))
    return f"`{line['task']}`", " ".join(line["engines"]), *shares, *gaps, f"{line['late'] * 1000:.1f} ms"


def main() -> None:
    """Rewrite the section."""
    if len(sys.argv) != 2:
        sys.exit("python -m tools.agreement FILE: give the file that `wmspec crosscheck --json FILE` wrote")
    record = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    told, mark, _ = PAGE.read_text(encoding="utf-8").partition(MARK)
    PAGE.write_text(told + mark + "\n" + "\n".join(measured(record)), encoding="utf-8")


if __name__ == "__main__":
    main()
