"""A contact sheet of a dataset: a few instances of each task, engine under engine, to be understood at a glance."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

from PIL import Image

from wmspec.core.diagnostics import WmsError
from wmspec.dataset.build import typeset
from wmspec.dataset.build.pictures import opened
from wmspec.dataset.build.reader import PICTURES, DatasetReader
from wmspec.dataset.build.rows import Row
from wmspec.dataset.build.typeset import BLACK, GREEN, GREY, PALE, Picture, Style
from wmspec.dataset.build.words import human, reading

#: The width of everything on the sheet (px), and of what is in its columns.
WIDTH, MARGIN, ENGINE, GAP, PARTING, ROOM = 2000, 56, 150, 10, 44, 6
LARGEST, WORDS = 384, 430

#: What is kept, by the consensus asked for.
AGREED = {"all": "; only what all of them agree on", "majority": "; only what most of them agree on", "none": ""}

LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"

TITLE, TASK, QUESTION = Style(46, bold=True), Style(34, bold=True), Style(28, bold=True)
BODY, SMALL, TINY = Style(22), Style(20, GREY), Style(17, GREY)
NAME, TRUE = Style(20, bold=True), Style(20, GREEN, bold=True)


def contact_sheet(folder: Path, count: int = 3, tasks: Sequence[str] | None = None) -> Picture:
    """A sheet, 2000 px wide, with `count` instances of each task (or of the named ones) of a finished dataset.

    Raises WmsError if there is no finished dataset in the folder, if it is damaged, or has no such task.
    """
    dataset = DatasetReader.open(folder)
    manifest = dataset.manifest
    chosen = list(manifest["tasks"]) if tasks is None else list(tasks)
    for name in chosen:
        if name not in manifest["tasks"]:
            raise WmsError(f"{folder} has no task `{name}`; it has {', '.join(manifest['tasks'])}")
    dataset.intact()
    parts = [_title(manifest)]
    parts += [_task(dataset, name, count) for name in chosen]
    return typeset.padded(typeset.above(parts, 70), MARGIN)


def question_of(dataset: DatasetReader, task: str) -> Picture | None:
    """One question of a task, in the first engine that asks it, 2000 px wide; None if it has none.

    Raises WmsError if a shard cannot be read.
    """
    for rows, units in _picked(dataset, task, 1):
        return typeset.padded(_question(rows[:1], units), MARGIN)
    return None


def _inside() -> int:
    return WIDTH - 2 * MARGIN


# ---------------------------------------------------------------- tasks


def _title(manifest: dict[str, Any]) -> Picture:
    engines = ", ".join(manifest["engines"])
    agreed = AGREED[manifest["consensus"]]
    tasks = f"{len(manifest['tasks'])} {'task' if len(manifest['tasks']) == 1 else 'tasks'}"
    counted = f"{manifest['rows']:,} questions in {tasks}, executed and drawn in {engines}{agreed}"
    return typeset.above(
        [typeset.paragraph("wmspec", TITLE, _inside()), typeset.paragraph(counted, SMALL, _inside())], 4
    )


def _task(dataset: DatasetReader, name: str, count: int) -> Picture:
    about = dataset.manifest["tasks"][name]
    head = [typeset.rule(_inside(), BLACK, 3), typeset.paragraph(about["title"] or name, TASK, _inside())]
    head += [typeset.paragraph(f"{name}  ·  {about['dimension']}  ·  {_kept(about)}", SMALL, _inside())]
    shown = [_question(list(rows), units) for rows, units in _picked(dataset, name, count)]
    nothing = typeset.paragraph("every question was rejected", BODY, _inside())
    return typeset.above([typeset.above(head, 8), *(shown or [nothing])], 40)


def _kept(about: dict[str, Any]) -> str:
    rows, lost = sum(about["rows"].values()), sum(about["rejected"].values())
    return f"{rows:,} questions kept, {lost:,} rejected"


def _picked(dataset: DatasetReader, task: str, count: int) -> Iterator[tuple[list[Row], dict[str, str]]]:
    """The rows of `count` questions, engine by engine, spread over the task; those that all engines ask come first."""
    units = dataset.units(task)
    chosen = _spread(list(dataset.rows(task, ["index", "question", "engine"])), count)
    rows = [_decoded(row) for row in dataset.rows(task, only={index for index, _ in chosen})]
    for which in chosen:
        same = [row for row in rows if (row["index"], row["question"]) == which]
        yield sorted(same, key=lambda r: dataset.engines.index(r["engine"])), units


def _spread(keys: list[Row], count: int) -> list[tuple[int, int]]:
    engines_of: dict[tuple[int, int], int] = {}
    for key in keys:
        which = (key["index"], key["question"])
        engines_of[which] = engines_of.get(which, 0) + 1
    most = max(engines_of.values(), default=0)
    best = [which for which, engines in engines_of.items() if engines == most]
    best += [which for which, engines in engines_of.items() if engines < most] if len(best) < count else []
    shown = min(count, len(best))
    return [best[i * len(best) // shown] for i in range(shown)]


def _decoded(row: Row) -> Row:
    return row | {name: [opened(p["bytes"]) for p in row[name]] for name in PICTURES}


# ---------------------------------------------------------------- a question


def _question(rows: list[Row], units: dict[str, str]) -> Picture:
    first = rows[0]
    head = [
        typeset.paragraph(first["text"], QUESTION, _inside()),
        typeset.paragraph(_factors(first, units), SMALL, _inside()),
    ]
    side = _side(first)
    lines: list[Picture] = []
    for heading, same in groupby(rows, key=_heading):
        lines.append(_headings(heading, side))
        lines += [_row(row, side) for row in same]
    return typeset.above([typeset.above(head, 6), typeset.above(lines, 8), _reasons(rows)], 16)


def _factors(row: Row, units: dict[str, str]) -> str:
    """The instance in words: its factors, then its nuisances."""
    named = [(name, value) for name, value in row.items() if name.startswith(("factor.", "nuisance."))]
    values = "  ·  ".join(f"{name.partition('.')[2]} {human(value, units.get(name, ''))}" for name, value in named)
    return f"instance {row['index']}:  {values}"


def _side(row: Row) -> int:
    """How wide every picture of a question is drawn (px)."""
    shown, choices = len(row["context"]), len(row["option_image"])
    words = 0 if choices else WORDS
    free = _inside() - ENGINE - PARTING - 2 * GAP - words - (shown + choices) * (GAP + 2 * ROOM)
    return min(LARGEST, free // max(shown + choices, 1))


# ---------------------------------------------------------------- above the pictures


@dataclass(frozen=True)
class _Heading:
    """What stands above the pictures of a row: of the context when and where, of the options kind, name and change."""

    context: tuple[str, ...]
    options: tuple[tuple[str, str, str], ...]


def _heading(row: Row) -> _Heading:
    looks = zip(row["context_time"], row["context_camera"], strict=True)
    context = tuple(f"{time:.3g} s, {camera}" for time, camera in looks)
    if not row["option_image"]:
        return _Heading(context, ())
    changes = [change or "" for change in row["option_change"]]
    return _Heading(context, tuple(zip(row["option_kind"], row["option_name"], changes, strict=True)))


def _headings(heading: _Heading, side: int) -> Picture:
    wide = side + 2 * ROOM
    shown = [typeset.paragraph(words, SMALL, wide, centred=True) for words in heading.context]
    left = _over("what is shown", typeset.beside(shown, GAP))
    options = [_option(LETTERS[i], option, wide) for i, option in enumerate(heading.options)]
    prompt = "which picture is true?" if options else "which is true?"
    right = _over(prompt, typeset.beside(options or [typeset.blank(WORDS, 1)], GAP))
    return typeset.beside([typeset.blank(ENGINE, 1), left, typeset.blank(PARTING, 1), right], GAP)


def _over(words: str, part: Picture) -> Picture:
    return typeset.above([typeset.paragraph(words, TINY, part.width), typeset.rule(part.width), part], 5)


def _option(letter: str, option: tuple[str, str, str], wide: int) -> Picture:
    kind, name, change = option
    if kind == "truth":
        head = typeset.beside(
            [typeset.paragraph(letter, TRUE, typeset.width_of(letter, TRUE)), typeset.tick(22)], 8, middle=True
        )
        lines = ["this happens"]
    else:
        head = typeset.paragraph(f"{letter}  {name}", NAME, wide)
        lines = change.replace("->", "→").split(": ", 1)
    return typeset.above([head, *(typeset.paragraph(line, TINY, wide) for line in lines)], 2)


# ---------------------------------------------------------------- the pictures


def _row(row: Row, side: int) -> Picture:
    engine = typeset.paragraph(row["engine"], NAME, ENGINE)
    if row["renderer"] != row["engine"]:
        engine = typeset.above([engine, typeset.paragraph(f"drawn by {row['renderer']}", TINY, ENGINE)])
    context = [typeset.framed(_sized(p, side), PALE, 1, ROOM) for p in row["context"]]
    return typeset.beside([engine, *context, typeset.blank(PARTING, 1), *_choices(row, side)], GAP, middle=True)


def _choices(row: Row, side: int) -> list[Picture]:
    if not row["option_image"]:
        words = [_word(row, i) for i in range(len(row["option_text"]))]
        return [typeset.above(words or [typeset.paragraph("asked for openly", BODY, WORDS)], 4)]
    frames = [(GREEN, 6) if i == row["answer"] else (PALE, 1) for i in range(len(row["option_image"]))]
    return [typeset.framed(_sized(p, side), *frame, ROOM) for p, frame in zip(row["option_image"], frames, strict=True)]


def _word(row: Row, i: int) -> Picture:
    true = i == row["answer"]
    words = typeset.paragraph(f"{LETTERS[i]}  {row['option_text'][i]}", TRUE if true else BODY, WORDS - 80)
    line = typeset.beside([words, typeset.tick(24) if true else typeset.blank(24, 24)], 8, middle=True)
    return typeset.framed(typeset.padded(line, 8), GREEN if true else PALE, 4 if true else 1, ROOM)


def _sized(picture: Picture, side: int) -> Picture:
    height = max(1, round(side * picture.height / picture.width))
    return picture.resize((side, height), Image.Resampling.LANCZOS)


# ---------------------------------------------------------------- why


def _reasons(rows: list[Row]) -> Picture:
    """Why the answer is the answer, once for all engines that measured the same."""
    engines_by_reason: dict[str, list[str]] = {}
    for row in rows:
        engines_by_reason.setdefault(_reason(row), []).append(row["engine"])
    lines = [
        typeset.paragraph(f"{', '.join(engines)}:  {why}", BODY, _inside())
        for why, engines in engines_by_reason.items()
    ]
    return typeset.above(lines, 2)


def _reason(row: Row) -> str:
    true = "the answer is " if row["answer"] is None else f"{LETTERS[row['answer']]} is true: "
    parts = [true + row["answer_value"]]
    parts += [f"{m['name']} = {reading(m['name'], m['value'])}" for m in row["measured"]]
    if row["margin"] is not None:
        parts.append(f"{row['margin']:.2g} times the margin asked for")
    return "  ·  ".join(parts)
