"""Write the results of docs/benchmarks/audit.md from files `audit.json`, which `wmspec audit DATASET -o REPORT` writes.

    python -m tools.audits REPORT/audit.json...

Give one file, or several of different tasks, for each seed. All must be of one version of wmspec and of the engines.
"""

from __future__ import annotations

import datetime as dt
import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from tools.reference import table

PAGE = Path(__file__).parent.parent / "docs/benchmarks/audit.md"
MARK = "<!-- measured -->\n"
VERDICTS = {"holds": "pass", "unclear": "unknown", "fails": "**fail**"}

Record = dict[str, Any]
#: The summary and the failed checks of a task, by name and seed.
Results = Mapping[tuple[str, int], tuple[Record, Sequence[Record]]]


def results(reports: Sequence[Record]) -> Results:
    """Return the results of all reports. Raises ValueError if two have the same task and seed."""
    made: dict[tuple[str, int], tuple[Record, Sequence[Record]]] = {}
    for report in reports:
        for summary in report["summaries"]:
            key = summary["task"], int(report["about"]["seed"])
            if key in made:
                raise ValueError(f"two reports have `{key[0]}` with seed {key[1]}")
            failed = [f for f in report["findings"] if f["verdict"] == "fails" and _task(f) == key[0]]
            made[key] = summary, failed
    return made


def _task(finding: Record) -> str:
    return str(finding["task"]).partition(" ")[0]


def measured(reports: Sequence[Record], today: dt.date) -> Iterator[str]:
    """Yield the lines of the section."""
    found = results(reports)
    seeds, tasks = sorted({seed for _, seed in found}), sorted({task for task, _ in found})
    of_task = {task: [found[task, seed] for seed in seeds if (task, seed) in found] for task in tasks}
    passed = sum(all(summary["verdict"] == "holds" for summary, _ in each) for each in of_task.values())
    about = reports[0]["about"]
    versions = ", ".join(f"{name} {version}" for name, version in sorted(about["versions"].items()))
    yield f"Measured on {today.isoformat()} with {versions}, at {about['size'][0]} px.\n"
    yield f"{passed} of {len(tasks)} tasks pass with every seed that was measured.\n"
    heads = ("task", *(f"seed {seed}" for seed in seeds), "best probe", "above chance", "detectable shortcut")
    yield from table(heads, (_row(task, seeds, found) for task in tasks))
    failures = [(task, seed, f) for task in tasks for seed in seeds for f in found.get((task, seed), ({}, ()))[1]]
    yield "Failed checks:\n" if failures else "No check fails."
    for _, seed, finding in failures:
        yield f"- `{finding['task']}`, seed {seed}, {finding['check']}: {finding['what']}"


def _row(task: str, seeds: Sequence[int], found: Results) -> tuple[str, ...]:
    """Return the row of a task: verdict and number of questions for each seed, and the worst probe over the seeds."""
    summaries = {seed: found[task, seed][0] for seed in seeds if (task, seed) in found}
    cells = (_cell(summaries[seed]) if seed in summaries else "" for seed in seeds)
    worst = max(summaries.values(), key=lambda summary: summary["above"] or 0)
    least = max((s["least"] for s in summaries.values() if s["least"] is not None), default=None)
    above = "" if worst["above"] is None else f"{100 * worst['above']:.0f} points"
    shortcut = "" if least is None else f"{100 * least:.0f} points" if least < 1 else "none of 30"
    return f"`{task}`", *cells, worst["best"], above, shortcut


def _cell(summary: Record) -> str:
    why = "" if summary["verdict"] == "holds" else f" ({', '.join(summary['why'])})"
    return f"{VERDICTS[summary['verdict']]}, {summary['questions']:,}{why}"


def main() -> None:
    """Rewrite the section."""
    reports = [json.loads(Path(name).read_text(encoding="utf-8")) for name in sys.argv[1:]]
    if not reports:
        sys.exit(__doc__)
    if any(r["about"][k] != reports[0]["about"][k] for r in reports for k in ("versions", "engines", "size")):
        sys.exit("these reports are of different versions, engines or sizes: generate all datasets alike")
    head, mark, _ = PAGE.read_text(encoding="utf-8").partition(MARK)
    if not mark:
        sys.exit(f"{PAGE} has no line {MARK.strip()}")
    lines = measured(reports, dt.date.today())
    try:
        PAGE.write_text(head + mark + "\n" + "\n".join(lines).rstrip() + "\n", encoding="utf-8")
    except ValueError as error:
        sys.exit(str(error))


if __name__ == "__main__":
    main()
