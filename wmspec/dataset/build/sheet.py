"""Contact sheets: a few instances of each task, with one row for each engine; and one question of each for the card."""

from __future__ import annotations

import io
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from wmspec.dataset.build import typeset
from wmspec.dataset.build.card import example
from wmspec.dataset.build.films import read_frames, shown_film
from wmspec.dataset.build.format_units import format_reading, format_value
from wmspec.dataset.build.images import decode_image
from wmspec.dataset.build.reader import PICTURES, DatasetReader
from wmspec.dataset.build.rows import Row
from wmspec.dataset.build.typeset import BLACK, GREEN, GREY, PALE, Picture, Style

#: The width of the sheet and of its columns, margins and gaps, and the width inside the margins (px).
WIDTH, MARGIN, ENGINE, GAP, PARTING, ROOM = 2000, 56, 150, 10, 44, 6
INNER = WIDTH - 2 * MARGIN
LARGEST, WORDS = 384, 430
#: Number of frames of a film on the sheet.
FILM_FRAMES = 8

#: Description of each consensus setting.
CONSENSUS_TEXT = {
    "all": "; only what all of them agree on",
    "majority": "; only what most of them agree on",
    "none": "",
}

LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"

TITLE, TASK, QUESTION = Style(46, bold=True), Style(34, bold=True), Style(28, bold=True)
BODY, SMALL, TINY = Style(22), Style(20, GREY), Style(17, GREY)
NAME, TRUE = Style(20, bold=True), Style(20, GREEN, bold=True)


def contact_sheet(folder: Path, count: int = 3) -> Picture:
    """Return a sheet, 2000 px wide, with `count` instances of each task.

    Raises WmsError if the folder holds no finished dataset, or a damaged one.
    """
    dataset = DatasetReader.open(folder)
    manifest = dataset.manifest
    dataset.intact()
    parts = [_title(manifest)]
    parts += [_task(dataset, name, count) for name in manifest["tasks"]]
    return typeset.pad(typeset.vstack(parts, 70), MARGIN)


def question_of(dataset: DatasetReader, task: str) -> Picture | None:
    """Return one question of a task in the first engine that has it, 2000 px wide; None if the task has none.

    Raises WmsError if a shard cannot be read.
    """
    for rows, units in _selected_rows(dataset, task, 1):
        return typeset.pad(_question(rows[:1], units), MARGIN)
    return None


# ---------------------------------------------------------------- tasks


def _title(manifest: dict[str, Any]) -> Picture:
    engines = ", ".join(manifest["engines"])
    agreed = CONSENSUS_TEXT[manifest["consensus"]]
    tasks = f"{len(manifest['tasks'])} {'task' if len(manifest['tasks']) == 1 else 'tasks'}"
    counted = f"{manifest['rows']:,} questions in {tasks}, executed in {engines}{agreed}"
    return typeset.vstack([typeset.paragraph("wmspec", TITLE, INNER), typeset.paragraph(counted, SMALL, INNER)], 4)


def _task(dataset: DatasetReader, name: str, count: int) -> Picture:
    about = dataset.manifest["tasks"][name]
    head = [typeset.rule(INNER, BLACK, 3), typeset.paragraph(about["title"] or name, TASK, INNER)]
    head += [typeset.paragraph(f"{name}  ·  {about['dimension']}  ·  {_kept_text(about)}", SMALL, INNER)]
    shown = [_question(list(rows), units) for rows, units in _selected_rows(dataset, name, count)]
    nothing = typeset.paragraph("every question was rejected", BODY, INNER)
    return typeset.vstack([typeset.vstack(head, 8), *(shown or [nothing])], 40)


def _kept_text(about: dict[str, Any]) -> str:
    rows, lost = sum(about["rows"].values()), sum(about["rejected"].values())
    return f"{rows:,} questions kept, {lost:,} rejected"


def _selected_rows(dataset: DatasetReader, task: str, count: int) -> Iterator[tuple[list[Row], dict[str, str]]]:
    """Yield the rows of `count` questions, engine by engine, spread over the task.

    Questions that all engines have come first.
    """
    units = dataset.units(task)
    chosen = _spaced_keys(list(dataset.rows(task, ["index", "question", "engine"])), count)
    rows = [_decode(row, dataset.folder) for row in dataset.rows(task, only={index for index, _ in chosen})]
    for which in chosen:
        same = [row for row in rows if (row["index"], row["question"]) == which]
        yield sorted(same, key=lambda r: dataset.engines.index(r["engine"])), units


def _spaced_keys(keys: list[Row], count: int) -> list[tuple[int, int]]:
    engines_of: dict[tuple[int, int], int] = {}
    for key in keys:
        which = (key["index"], key["question"])
        engines_of[which] = engines_of.get(which, 0) + 1
    most = max(engines_of.values(), default=0)
    best = [which for which, engines in engines_of.items() if engines == most]
    best += [which for which, engines in engines_of.items() if engines < most] if len(best) < count else []
    shown = min(count, len(best))
    return [best[i * len(best) // shown] for i in range(shown)]


def _decode(row: Row, folder: Path) -> Row:
    """Return a row with decoded pictures, and with the `strip` of its film: a caption and a picture of some frames."""
    film, strip = shown_film(folder, row), list[tuple[str, Picture]]()
    if film is not None:
        frames = read_frames(folder, film.path)
        for k in np.unique(np.linspace(0, len(frames) - 1, FILM_FRAMES).round().astype(int)):
            shown = "" if k < film.count else ", not shown"
            strip.append((f"{film.start + k / film.rate:.2f} s{shown}", Image.fromarray(frames[k])))
    return row | {name: [decode_image(p["bytes"]) for p in row[name]] for name in PICTURES} | {"strip": strip}


# ---------------------------------------------------------------- questions


def _question(rows: list[Row], units: dict[str, str]) -> Picture:
    first = rows[0]
    head = [
        typeset.paragraph(first["text"], QUESTION, INNER),
        typeset.paragraph(_factors(first, units), SMALL, INNER),
    ]
    side = _side(first)
    lines: list[Picture] = []
    for heading, same in groupby(rows, key=_heading):
        lines.append(_headings(heading, side))
        lines += [_row(row, side) for row in same]
    strips = [typeset.vstack([_strip(row) for row in rows if row["strip"]], 8)] if any(r["strip"] for r in rows) else []
    return typeset.vstack([typeset.vstack(head, 6), typeset.vstack(lines, 8), *strips, _reasons(rows)], 16)


def _strip(row: Row) -> Picture:
    """Return frames of a row's film under their times, those of the context and of what then happens."""
    side = (INNER - ENGINE - (len(row["strip"]) - 1) * GAP) // len(row["strip"]) - GAP
    frames = [
        typeset.vstack([typeset.paragraph(words, TINY, side), _resized(picture, side)], 2)
        for words, picture in row["strip"]
    ]
    return typeset.hstack([typeset.paragraph(f"film, {row['engine']}", TINY, ENGINE), *frames], GAP)


def _factors(row: Row, units: dict[str, str]) -> str:
    """Return the factors and nuisances of an instance in words."""
    named = [(name, value) for name, value in row.items() if name.startswith(("factor.", "nuisance."))]
    values = "  ·  ".join(
        f"{name.partition('.')[2]} {format_value(value, units.get(name, ''))}" for name, value in named
    )
    return f"instance {row['index']}:  {values}"


def _side(row: Row) -> int:
    """Return the width of the pictures of a question (px)."""
    shown, choices = len(row["context"]), len(row["option_image"])
    words = 0 if choices else WORDS
    free = INNER - ENGINE - PARTING - 2 * GAP - words - (shown + choices) * (GAP + 2 * ROOM)
    return min(LARGEST, free // max(shown + choices, 1))


# ---------------------------------------------------------------- captions


#: The captions of a row: camera and time for context pictures; kind, name and change for options.
_Heading = tuple[tuple[str, ...], tuple[tuple[str, str, str], ...]]


def _heading(row: Row) -> _Heading:
    looks = zip(row["context_time"], row["context_camera"], strict=True)
    context = tuple(f"{time:.3g} s, {camera}" for time, camera in looks)
    if not row["option_image"]:
        return context, ()
    changes = [change or "" for change in row["option_change"]]
    return context, tuple(zip(row["option_kind"], row["option_name"], changes, strict=True))


def _headings(heading: _Heading, side: int) -> Picture:
    (context, changes), wide = heading, side + 2 * ROOM
    shown = [typeset.paragraph(words, SMALL, wide, centred=True) for words in context]
    left = _captioned("what is shown", typeset.hstack(shown, GAP))
    options = [_option(LETTERS[i], option, wide) for i, option in enumerate(changes)]
    prompt = "which picture is true?" if options else "which is true?"
    right = _captioned(prompt, typeset.hstack(options or [typeset.blank(WORDS, 1)], GAP))
    return typeset.hstack([typeset.blank(ENGINE, 1), left, typeset.blank(PARTING, 1), right], GAP)


def _captioned(words: str, part: Picture) -> Picture:
    return typeset.vstack([typeset.paragraph(words, TINY, part.width), typeset.rule(part.width), part], 5)


def _option(letter: str, option: tuple[str, str, str], wide: int) -> Picture:
    kind, name, change = option
    if kind == "truth":
        head = typeset.hstack(
            [typeset.paragraph(letter, TRUE, typeset.width_of(letter, TRUE)), typeset.tick(22)], 8, middle=True
        )
        lines = ["this happens"]
    else:
        head = typeset.paragraph(f"{letter}  {name}", NAME, wide)
        lines = change.replace("->", "→").split(": ", 1)
    return typeset.vstack([head, *(typeset.paragraph(line, TINY, wide) for line in lines)], 2)


# ---------------------------------------------------------------- pictures


def _row(row: Row, side: int) -> Picture:
    engine = typeset.paragraph(row["engine"], NAME, ENGINE)
    if row["renderer"] != row["engine"]:
        engine = typeset.vstack([engine, typeset.paragraph(f"drawn by {row['renderer']}", TINY, ENGINE)])
    context = [typeset.frame(_resized(p, side), PALE, 1, ROOM) for p in row["context"]]
    return typeset.hstack([engine, *context, typeset.blank(PARTING, 1), *_choices(row, side)], GAP, middle=True)


def _choices(row: Row, side: int) -> list[Picture]:
    if not row["option_image"]:
        words = [_word(row, i) for i in range(len(row["option_text"]))]
        return [typeset.vstack(words or [typeset.paragraph("free answer", BODY, WORDS)], 4)]
    frames = [(GREEN, 6) if i == row["answer"] else (PALE, 1) for i in range(len(row["option_image"]))]
    return [
        typeset.frame(_resized(p, side), *frame, ROOM) for p, frame in zip(row["option_image"], frames, strict=True)
    ]


def _word(row: Row, i: int) -> Picture:
    true = i == row["answer"]
    words = typeset.paragraph(f"{LETTERS[i]}  {row['option_text'][i]}", TRUE if true else BODY, WORDS - 80)
    line = typeset.hstack([words, typeset.tick(24) if true else typeset.blank(24, 24)], 8, middle=True)
    return typeset.frame(typeset.pad(line, 8), GREEN if true else PALE, 4 if true else 1, ROOM)


def _resized(picture: Picture, side: int) -> Picture:
    height = max(1, round(side * picture.height / picture.width))
    return picture.resize((side, height), Image.Resampling.LANCZOS)


# ---------------------------------------------------------------- explanations


def _reasons(rows: list[Row]) -> Picture:
    """Return the explanation of the answer, once for all engines that measured the same."""
    engines_by_reason: dict[str, list[str]] = {}
    for row in rows:
        engines_by_reason.setdefault(_reason(row), []).append(row["engine"])
    lines = [
        typeset.paragraph(f"{', '.join(engines)}:  {why}", BODY, INNER) for why, engines in engines_by_reason.items()
    ]
    return typeset.vstack(lines, 2)


def _reason(row: Row) -> str:
    true = "the answer is " if row["answer"] is None else f"{LETTERS[row['answer']]} is true: "
    parts = [true + row["answer_value"]]
    parts += [f"{m['name']} = {format_reading(m['name'], m['value'])}" for m in row["measured"]]
    if row["margin"] is not None:
        parts.append(f"{row['margin']:.2g} times the required margin")
    return "  ·  ".join(parts)


#: The width of an example (px), and its WebP quality.
EXAMPLE_WIDTH, QUALITY = 1000, 80


def examples(dataset: DatasetReader) -> Iterator[tuple[str, bytes]]:
    """Yield the path and content of the example of every task that has questions.

    Raises WmsError if a shard cannot be read.
    """
    for task in dataset.tasks:
        shown = question_of(dataset, task)
        if shown is not None:
            out = io.BytesIO()
            small = shown.resize(
                (EXAMPLE_WIDTH, round(shown.height * EXAMPLE_WIDTH / shown.width)), Image.Resampling.LANCZOS
            )
            small.save(out, "WEBP", quality=QUALITY, method=4)
            yield example(task), out.getvalue()
