"""Reading tests: sheets of questions without answers, and the score of the answers that readers gave.

    python -m tools.reading sheets DATASET SHEETS KEY [--per-tier 5] [--seed 0]
    python -m tools.reading score KEY ANSWERS...

`sheets` draws one PNG for each question at the native size of its pictures. Their names, order and options say nothing
of task, level or answer. SHEETS is what readers get; KEY is a CSV file that they do not get. Readers write CSV files
with the columns `sheet`, `answer` (the letter of an option) and `confidence` (1 to 5). `score` prints accuracy by task
and tier, with Wilson's intervals, and every wrong answer.
"""

from __future__ import annotations

import argparse
import csv
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from scipy.stats import binomtest

from wmspec.core.rng import Permutation
from wmspec.dataset.build import typeset
from wmspec.dataset.build.images import decode_image
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.build.typeset import Picture, Style

#: Give sheets of one `group` to different readers, because its questions may reveal each other's answers.
COLUMNS = ("sheet", "task", "question", "tier", "options", "answer", "id", "group")
LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
TEXT, LETTER = Style(20), Style(22, bold=True)
GAP, ACROSS = 8, 4
#: Minimum width (px) of a sheet: that of two pictures.
MIN_WIDTH = 776


def questions(dataset: DatasetReader, per_tier: int, seed: int) -> Iterator[dict[str, Any]]:
    """Yield `per_tier` random rows of every question and tier (the value of `difference`).

    They are of as many control groups as possible.
    """
    for task in dataset.tasks:
        tiers: dict[tuple[int, float | None], list[dict[str, Any]]] = defaultdict(list)
        columns = ("id", "question", "block", "engine", "option_kind", "difference")
        for row in dataset.rows(task, columns):
            if row["engine"] == dataset.engines[0] and row["option_kind"]:
                strength = row["difference"]
                level = None if strength is None else round(float(strength["value"]), 3)
                tiers[row["question"], level].append(row)
        chosen: dict[str, float | None] = {}
        for (question, tier), rows in tiers.items():
            order = Permutation(len(rows), seed, task, question, str(tier))
            shuffled = [rows[order(n)] for n in range(len(rows))]
            apart = list({row["block"]: row for row in shuffled}.values())
            rest = [row for row in shuffled if row not in apart]
            chosen |= {row["id"]: tier for row in [*apart, *rest][:per_tier]}
        for row in dataset.rows(task):
            if row["id"] in chosen:
                yield row | {"tier": chosen[row["id"]]}


def sheet(text: str, context: Sequence[Picture], options: Sequence[Picture | str]) -> Picture:
    """Return the sheet of a question: text, shown pictures, options; pictures at their native size."""
    lettered = [
        typeset.vstack([typeset.paragraph(letter, LETTER, option.width), option])
        for letter, option in zip(LETTERS, options, strict=False)
        if not isinstance(option, str)
    ]
    pictures = [*_grid(context), *_grid(lettered)]
    width = max(MIN_WIDTH, *(each.width for each in pictures))
    offered = [
        typeset.paragraph(f"{letter}: {option}", TEXT, width)
        for letter, option in zip(LETTERS, options, strict=False)
        if isinstance(option, str)
    ]
    return typeset.vstack([typeset.paragraph(text, TEXT, width), *pictures, *offered], GAP)


def _sheet_of_row(row: dict[str, Any]) -> Picture:
    context = [decode_image(p["bytes"]) for p in row["context"]]
    return sheet(row["text"], context, row["option_text"] or [decode_image(p["bytes"]) for p in row["option_image"]])


def _grid(pictures: Sequence[Picture]) -> list[Picture]:
    return [typeset.hstack(pictures[n : n + ACROSS], GAP) for n in range(0, len(pictures), ACROSS)]


def draw(dataset: Path, sheets: Path, key: Path, per_tier: int, seed: int) -> None:
    """Write the sheets and their key."""
    sheets.mkdir(parents=True, exist_ok=True)
    rows = list(questions(DatasetReader.open(dataset), per_tier, seed))
    order = Permutation(len(rows), seed, "sheets")
    with key.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(COLUMNS)
        for number in range(len(rows)):
            row = rows[order(number)]
            name = f"{number:04d}.png"
            _sheet_of_row(row).save(sheets / name)
            question = row["question_name"] or row["question"]
            right = LETTERS[row["answer"]]
            count = len(row["option_kind"])
            table.writerow([name, row["task"], question, row["tier"], count, right, row["id"], row["block"]])


def score(key: Path, answers: Sequence[Path]) -> Iterator[str]:
    """Yield a table of accuracy by task, question and tier, and the wrong answers."""
    truth = {row["sheet"]: row for row in csv.DictReader(key.open())}
    given = [row for path in answers for row in csv.DictReader(path.open())]
    counts: dict[tuple[str, str, str], list[bool]] = defaultdict(list)
    wrong = []
    for row in given:
        keyed = truth[row["sheet"]]
        right = row["answer"].strip().upper() == keyed["answer"]
        counts[keyed["task"], keyed["question"], keyed["tier"]].append(right)
        if not right:
            wrong.append(
                f"{row['sheet']} {keyed['task']} {keyed['tier']} {keyed['id']}: {row['answer']}, not {keyed['answer']}"
            )
    yield "| task | question | tier | right | 95 % interval |\n|---|---|---|---|---|"
    for (task, question, tier), results in sorted(counts.items()):
        low, high = binomtest(sum(results), len(results)).proportion_ci(method="wilson")
        yield f"| `{task}` | {question} | {tier or '—'} | {sum(results)} of {len(results)} | {low:.0%} to {high:.0%} |"
    yield from wrong


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    making = commands.add_parser("sheets")
    for name in ("dataset", "sheets", "key"):
        making.add_argument(name, type=Path)
    making.add_argument("--per-tier", type=int, default=5)
    making.add_argument("--seed", type=int, default=0)
    making.set_defaults(run=lambda a: draw(a.dataset, a.sheets, a.key, a.per_tier, a.seed))
    scoring = commands.add_parser("score")
    scoring.add_argument("key", type=Path)
    scoring.add_argument("answers", type=Path, nargs="+")
    scoring.set_defaults(run=lambda a: print(*score(a.key, a.answers), sep="\n"))
    options = parser.parse_args()
    options.run(options)


if __name__ == "__main__":
    main()
