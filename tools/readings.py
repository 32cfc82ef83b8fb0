"""Sheets for readers who know nothing of a task, and what their answers score.

python -m tools.readings sheets DATASET... -o FOLDER -k KEYS     TASK/NN.png, TASK/questions.txt; keys apart
python -m tools.readings sheets ... --readers 4                  READER/TASK/...: no reader has two siblings of a group
python -m tools.readings score KEYS ANSWERS...                   a table in Markdown

A sheet shows what a model is shown: the pictures in order, the question, the options by letters. Nothing in FOLDER
tells what is true. An answers file is JSON: {"collide/000123/q0": "B", ...}.
"""

from __future__ import annotations

import argparse
import json
import shutil
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from tools.reference import table
from wmspec.core.rng import bits
from wmspec.dataset.audit.statistics import clopper_pearson
from wmspec.dataset.build import typeset
from wmspec.dataset.build.pictures import opened
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.build.rows import Row
from wmspec.dataset.build.sheet import LETTERS
from wmspec.dataset.build.typeset import PALE, Picture, Style

#: The width of a sheet (px), its margin, what is between two pictures, and how many questions a sheet has.
WIDTH, MARGIN, GAP, ROOM, A_SHEET = 1600, 30, 8, 3, 3
#: Of a task whose options are pictures, questions in words are companions: one for so many of the others.
COMPANIONS = 5

HEAD, BODY, SMALL = Style(24, bold=True), Style(24), Style(18, typeset.GREY)


# ---------------------------------------------------------------- which


def chosen(rows: Sequence[Row], count: int) -> list[Row]:
    """Of each question of a task so many instances: tiers in turn, and of as many groups as there are."""
    asked: dict[int, list[Row]] = defaultdict(list)
    for row in sorted(rows, key=lambda r: bits("reading", r["id"])):
        asked[row["question"]].append(row)
    pictured = any(row["option_image"] for row in rows)
    picked = []
    for same in asked.values():
        companion = pictured and not same[0]["option_image"]
        picked += _spread(same, max(1, count // COMPANIONS) if companion else count)
    return sorted(picked, key=lambda r: (r["question"], bits("order", r["id"])))


def _spread(rows: Sequence[Row], count: int) -> list[Row]:
    """So many rows, each of the tier, then of the group, that has been taken least."""
    tiers: dict[str, int] = defaultdict(int)
    groups: dict[int, int] = defaultdict(int)
    rest, picked = list(rows), list[Row]()
    while rest and len(picked) < count:
        row = min(rest, key=lambda r: (tiers[tier(r)], groups[r["block"]]))
        rest.remove(row)
        picked.append(row)
        tiers[tier(row)] += 1
        groups[row["block"]] += 1
    return picked


def tier(row: Row) -> str:
    """The tier of a question: what the value of the factor that `difference` names is called, or that value itself."""
    strength = row["difference"]
    if strength is None:
        return ""
    named = row.get(f"level.{strength['name']}")
    return str(named) if named else f"{row.get('factor.' + strength['name'], strength['value']):.3g}"


# ---------------------------------------------------------------- sheets


def dealt(rows: Sequence[Row], readers: int) -> list[list[Row]]:
    """A hand for each reader: siblings of a group, which settle each other, go to different readers."""
    hands: list[list[Row]] = [[] for _ in range(readers)]
    groups: dict[tuple[int, int], int] = {}
    for row in rows:
        group = (row["question"], row["block"])
        turn = groups[group] = groups.get(group, row["block"]) + 1
        hands[turn % readers].append(row)
    return hands


def sheets(dataset: DatasetReader, count: int, folder: Path, keys: Path, readers: int = 1) -> None:
    """The sheets of every task of a dataset for each reader, what they ask as text, and their key."""
    for task in dataset.tasks:
        rows = [r for r in dataset.rows(task) if r["engine"] == dataset.engines[0] and r["option_kind"]]
        picked = chosen(rows, count)
        for reader, hand in enumerate(dealt(picked, readers), 1):
            _write(hand, (folder / str(reader) if readers > 1 else folder) / task)
        keys.mkdir(parents=True, exist_ok=True)
        truth = {name_of(row): _key(row) for row in picked}
        (keys / f"{task}.json").write_text(json.dumps(truth, indent=1) + "\n", encoding="utf-8")


def _write(rows: Sequence[Row], place: Path) -> None:
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir(parents=True)
    text = []
    for number, start in enumerate(range(0, len(rows), A_SHEET), 1):
        some = rows[start : start + A_SHEET]
        page = typeset.above([_question(row) for row in some], 34)
        typeset.padded(page, MARGIN).save(place / f"{number:02d}.png", optimize=True)
        text += [f"Sheet {number:02d}.png", "", *(line for row in some for line in _words(row))]
    (place / "questions.txt").write_text("\n".join(text) + "\n", encoding="utf-8")


def name_of(row: Row) -> str:
    """What a reader calls a question: its id without the engine."""
    return str(row["id"]).rpartition("/")[0]


def _key(row: Row) -> dict[str, Any]:
    """What is true, and what a score is told by."""
    return {
        "task": row["task"],
        "question": row["question"],
        "name": row["question_name"] or "",
        "tier": tier(row),
        "answer": LETTERS[row["answer"]],
        "options": len(row["option_kind"]),
    }


def _words(row: Row) -> Iterator[str]:
    yield f"{name_of(row)}: {row['text']}"
    letters = LETTERS[: len(row["option_kind"])]
    yield from (f"  {a}. {b}" for a, b in zip(letters, row["option_text"] or ["(picture)"] * len(letters), strict=True))
    yield ""


def _question(row: Row) -> Picture:
    inside = WIDTH - 2 * MARGIN
    parts = [typeset.rule(inside), typeset.paragraph(name_of(row), SMALL, inside)]
    shown = [(f"Picture {n}", opened(p["bytes"])) for n, p in enumerate(row["context"], 1)]
    parts += _strip(shown, inside)
    parts.append(typeset.paragraph(row["text"], HEAD, inside))
    offered = [(LETTERS[n], opened(p["bytes"])) for n, p in enumerate(row["option_image"])]
    parts += _strip(offered, inside)
    parts += [typeset.paragraph(f"{LETTERS[n]}.  {o}", BODY, inside) for n, o in enumerate(row["option_text"] or ())]
    return typeset.above(parts, 10)


def _strip(pictures: Sequence[tuple[str, Picture]], inside: int) -> list[Picture]:
    """Pictures under their labels, at their own size, in as many lines as it takes."""
    pieces = [
        typeset.above([typeset.paragraph(label, HEAD, p.width), typeset.framed(p, PALE, 1, ROOM)], 2)
        for label, p in pictures
    ]
    if not pieces:
        return []
    each = max(1, inside // (pieces[0].width + GAP))
    return [typeset.beside(pieces[i : i + each], GAP) for i in range(0, len(pieces), each)]


# ---------------------------------------------------------------- scores


def scored(keys: Mapping[str, Mapping[str, Any]], answers: Sequence[Mapping[str, str]]) -> Iterator[str]:
    """A table: of every task, question and tier, how many of all answers are right, and the 95 % interval.

    Raises ValueError if a question is answered that was not asked.
    """
    given = [(name, letter) for one in answers for name, letter in one.items()]
    if strange := [name for name, _ in given if name not in keys]:
        raise ValueError(f"{len(strange)} answers are to no question, such as {strange[0]}")
    right: dict[tuple[str, str], dict[str, list[bool]]] = defaultdict(lambda: defaultdict(list))
    for name, letter in given:
        key = keys[name]
        right[key["task"], key["name"]][key["tier"]].append(letter.strip().upper()[:1] == key["answer"])
    lines = []
    for (task, question), tiers in sorted(right.items()):
        everything = [hit for hits in tiers.values() for hit in hits]
        low, high = clopper_pearson(sum(everything), len(everything), 0.95)
        by_tier = ", ".join(f"{name} {sum(hits)}/{len(hits)}" for name, hits in sorted(tiers.items(), key=_in_order))
        share = f"{sum(everything)}/{len(everything)}"
        lines.append((f"`{task}`", question or "–", share, f"{low:.0%} to {high:.0%}", by_tier))
    yield from table(("task", "question", "right", "95 %", "by tier"), lines)


def _in_order(item: tuple[str, list[bool]]) -> tuple[bool, float, str]:
    """Tiers that are numbers from the largest on, then those that have names."""
    try:
        return False, -float(item[0]), ""
    except ValueError:
        return True, 0.0, item[0]


def main() -> None:
    """Write sheets, or score answers."""
    parser = argparse.ArgumentParser(
        prog="python -m tools.readings", description=__doc__.splitlines()[0] if __doc__ else ""
    )
    verbs = parser.add_subparsers(dest="verb", required=True)
    making = verbs.add_parser("sheets", help="write sheets and keys")
    making.add_argument("datasets", nargs="+", type=Path)
    making.add_argument("-o", "--output", type=Path, required=True)
    making.add_argument("-k", "--keys", type=Path, required=True)
    making.add_argument("--count", type=int, default=30)
    making.add_argument("--readers", type=int, default=1)
    scoring = verbs.add_parser("score", help="score answers")
    scoring.add_argument("keys", type=Path)
    scoring.add_argument("answers", nargs="+", type=Path)
    asked = parser.parse_args()
    if asked.verb == "sheets":
        for folder in asked.datasets:
            sheets(DatasetReader.open(folder), asked.count, asked.output, asked.keys, asked.readers)
        return
    keys = {
        name: key for file in sorted(asked.keys.glob("*.json")) for name, key in json.loads(file.read_text()).items()
    }
    print("\n".join(scored(keys, [json.loads(file.read_text()) for file in asked.answers])))


if __name__ == "__main__":
    main()
