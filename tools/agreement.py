"""Write the table of docs/benchmarks/agreement.md from the files of `wmspec crosscheck --json FILE`.

python -m tools.agreement [--engine ENGINE] FILE...

With an engine: only its pairs with the others, into docs/benchmarks/ENGINE.md.
"""

from __future__ import annotations

import json
import sys
from argparse import ArgumentParser
from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

from tools.reference import table
from wmspec.runtime.compare.model import Cause, Verdict
from wmspec.runtime.compare.verbalize import dispute

PAGE = Path(__file__).parent.parent / "docs/benchmarks/agreement.md"
MARK = "<!-- measured -->\n"
#: What the columns of the table mean.
COLUMNS = """\
A cell such as `400/400` counts questions. The second number is the number of questions that are compared in a
pair of engines. The first is the number of those to which both engines give the same answer. The first columns
of pairs count kept questions only; those with *before gates* count all questions. The last two columns combine
all pairs. *Within tolerance* is the rounded share of episodes, counterfactuals included, in which no body is
out of [tolerance](../crosscheck.md#tolerances). The *largest gap* is the largest distance, in any episode,
between the positions of a body in two engines at the same time.
"""

Record = dict[str, Any]


def measured(records: Sequence[Record], engine: str | None = None) -> Iterator[str]:
    """Yield the lines of the section, of the pairs with `engine` if given.

    All records have the same engines and seed.
    """
    engines = ", ".join(f"{name} {version}" for name, version in records[0]["engines"].items())
    lines = sorted((line for record in records for line in record["summary"]), key=lambda line: line["task"])
    lines = [line for line in lines if engine is None or engine in line["engines"]]
    rows = {task: list(of_task) for task, of_task in groupby(lines, key=lambda line: line["task"])}
    instances = [instance for record in records for instance in record["instances"]]
    good, total = total_of(lines, "before_gates")
    yield f"{len(rows)} tasks, {len(instances):,} instances, seed {records[0]['seed']}, with {engines}."
    yield f"In {good:,} of {total:,} comparisons of a question in two engines ({good / total:.2%}), both engines have"
    yield "the same answer before any gate.\n"
    yield COLUMNS
    pairs = [" ".join(line["engines"]) for line in next(iter(rows.values()))]
    heads = ("task", *pairs, *(f"{pair}, before gates" for pair in pairs), "within tolerance", "largest gap")
    yield from table(heads, (row(*r) for r in rows.items()))
    yield from disagreements(instances)


def row(task: str, lines: Sequence[Record]) -> tuple[str, ...]:
    """Return the row of a task: its shares per pair of engines."""
    shares = (f"{line[k]['good']}/{line[k]['all']}" for k in ("answers", "before_gates") for line in lines)
    good, total = total_of(lines, "episodes")
    return f"`{task}`", *shares, f"{good / total:.0%}", f"{max(line['largest'] for line in lines) * 100:.2f} cm"


def total_of(lines: Sequence[Record], share: str) -> tuple[int, int]:
    """Return a share over all lines as (count, total)."""
    return sum(line[share]["good"] for line in lines), sum(line[share]["all"] for line in lines)


def disagreements(instances: Sequence[Record]) -> Iterator[str]:
    """Yield a line for each answer that differs and each instance that was not executed."""
    differing = [(i, v) for i in instances for v in i["verdicts"] if not v["agree"]]
    yield f"Answers that differ: {len(differing) or 'none'}.\n"
    for instance, verdict in differing:
        yield f"- `{instance['task']}`, instance {instance['index']}: {dispute(verdict_of(verdict))}"
    for instance in instances:
        for failure in instance["failures"]:
            yield f"- `{instance['task']}`, instance {instance['index']} was not executed: {failure['reason']}"


def verdict_of(record: Record) -> Verdict:
    """Return the verdict of a JSON record."""
    cause = record["cause"] and Cause(**record["cause"])
    return Verdict(**{k: v for k, v in record.items() if k not in ("asked", "cause")}, cause=cause)


def main() -> None:
    """Rewrite the section."""
    parser = ArgumentParser(description="Write a table of agreement.")
    parser.add_argument("--engine", help="only its pairs, into docs/benchmarks/ENGINE.md")
    parser.add_argument("files", nargs="+", help="what `wmspec crosscheck --json FILE` wrote")
    given = parser.parse_args()
    records = [json.loads(Path(name).read_text(encoding="utf-8")) for name in given.files]
    if any((r["engines"], r["seed"]) != (records[0]["engines"], records[0]["seed"]) for r in records):
        sys.exit("these files are of different engines or seeds: crosscheck all specs with the same")
    page = PAGE.with_name(f"{given.engine}.md") if given.engine else PAGE
    head, mark, _ = page.read_text(encoding="utf-8").partition(MARK)
    lines = "\n".join(measured(records, given.engine)).rstrip()
    page.write_text(head + mark + "\n" + lines + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
