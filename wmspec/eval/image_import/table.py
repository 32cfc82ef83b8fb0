"""The table that a person writes: one question a row. Every mistake is told with its row and column, all at once."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

from wmspec.core.diagnostics import Diagnostic, Report, WmsError, suggestion
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import read_plain
from wmspec.eval.image_import.pictures import CLIPS, STILLS, Pictures

#: The columns and what they hold; the first four have to be there.
COLUMNS = {
    "question": "the question's text",
    "pictures": "the files shown with it, in order, parted by `;`: photographs, or one clip",
    "options": "the options, parted by `;`: words, or files of photographs; empty for an open question",
    "answer": "the true option as it is written in `options`; of an open question, a number",
    "task": "the task, by default the table's name",
    "dimension": "what is tested, such as perception.space.relation; by default real",
    "name": "the question's name",
    "episode": "rows of a task with the same word here ask about the same thing shown",
    "group": "rows of a task with the same word here are not independent, such as photographs of one place",
    "frames": "how many pictures are taken from a clip, evenly; by default 4",
    "times": "the time (s) of each picture, parted by `;`; by default 0, 1, 2, ..., and of a clip its own",
    "difference": "how strong the stimulus is, a number",
    "quantity": "of what that is the number, such as `size(left) / size(right)`",
    "unit": "the unit of the difference, or of an open question's answer",
    "within": "of an open question: how far off a number is still right",
    "source": "where the pictures are from",
    "license": "under which licence they are",
}
NEEDED = ("question", "pictures", "options", "answer")
FACTOR = "factor."
#: How many pictures are taken from a clip, if nothing is said.
FRAMES = 4

_NAME = re.compile(r"[a-z][a-z0-9_]*")
_DIMENSION = re.compile(r"[a-z][a-z0-9_]*(\.[a-z][a-z0-9_]*)*")


@dataclass(frozen=True)
class Entry:
    """A row of the table that was found right.

    `line` is where it begins; `answer` is the place of the true option, None if the question is open. `pictured` tells
    whether the options are files. A `clip` gives `frames` pictures.
    """

    line: int
    task: str
    dimension: str
    name: str
    episode: str
    group: str
    text: str
    pictures: tuple[str, ...]
    clip: bool
    frames: int
    times: tuple[float, ...]
    options: tuple[str, ...]
    pictured: bool
    answer: int | None
    value: str
    number: float | None
    within: float | None
    unit: str
    difference: float | None
    quantity: str
    source: str
    license: str
    factors: dict[str, str] = field(default_factory=dict)


def read(path: Path, pictures: Pictures) -> tuple[Entry, ...]:
    """The rows of a table (CSV in UTF-8), checked, and all pictures that they name opened.

    Raises WmsError with every mistake: each with its row, its column and what would be right.
    """
    report = Report(WmsError)
    rows = list(_rows(path, report))
    entries = [_Row(path, line, cells, pictures, report).entry() for line, cells in rows]
    _alone(path, [entry for entry in entries if entry], report)
    if not rows and not report.failed:
        report.include(
            [Diagnostic("the table has no rows", FilePlace(str(path)), "write one question a row below the names")]
        )
    report.stop_if_failed()
    return tuple(entry for entry in entries if entry)


def _rows(path: Path, report: Report) -> Iterator[tuple[int, dict[str, str]]]:
    """Every row by column, with the line where it begins; nothing if the names of the columns are wrong."""
    try:
        text = read_plain(path).decode("utf-8-sig")
    except OSError as error:
        raise WmsError(f"cannot be read: {error.strerror}", FilePlace(str(path)), "give a .csv file") from None
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise WmsError("this is not UTF-8", FilePlace(str(path), line), "save the table as CSV in UTF-8") from None
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        head = [name.strip() for name in next(reader, [])]
        if not _named(path, head, report):
            return
        line = reader.line_num + 1
        for cells in reader:
            if len(cells) > len(head):
                message = f"the row has {len(cells)} cells, the table {len(head)} columns"
                report.include(
                    [Diagnostic(message, FilePlace(str(path), line), 'put a cell with a comma in it in "quotes"')]
                )
            elif any(cell.strip() for cell in cells):
                yield line, {name: cell.strip() for name, cell in zip(head, cells, strict=False)}
            line = reader.line_num + 1
    except csv.Error as error:
        place = FilePlace(str(path), reader.line_num)
        report.include(
            [Diagnostic(f"this is not CSV: {error}", place, 'write a quote inside of a quoted cell twice: ""')]
        )


def _named(path: Path, head: list[str], report: Report) -> bool:
    """Whether the columns are those that are known and needed."""
    place = FilePlace(str(path), 1)
    for name in NEEDED:
        if name not in head:
            close = suggestion(name, [n for n in head if n not in COLUMNS and n])
            remedy = f"call it so; it holds {COLUMNS[name]}" + (f"; {close}" if close.startswith("did") else "")
            report.include([Diagnostic(f"there is no column `{name}`", place, remedy)])
    for name in sorted({n for n in head if head.count(n) > 1}):
        report.include([Diagnostic(f"there are two columns `{name}`", place, "leave one out")])
    for name in head:
        known = name in COLUMNS or (name.startswith(FACTOR) and _NAME.fullmatch(name.removeprefix(FACTOR)))
        if not known:
            remedy = suggestion(name, COLUMNS) or f"known are {', '.join(COLUMNS)}, and {FACTOR}NAME for what varies"
            report.include([Diagnostic(f"column `{name}` is not known", place, remedy)])
    return not report.failed


def _alone(path: Path, entries: list[Entry], report: Report) -> None:
    """No two rows ask the same."""
    first: dict[object, int] = {}
    for entry in entries:
        key = (entry.task, entry.text, entry.pictures, frozenset(entry.options))
        if key in first:
            message = f"the row asks the same as the one in line {first[key]}"
            report.include([Diagnostic(message, FilePlace(str(path), entry.line), "leave one of them out")])
        first.setdefault(key, entry.line)


class _Row:
    """One row while it is checked."""

    def __init__(self, path: Path, line: int, cells: dict[str, str], pictures: Pictures, report: Report) -> None:
        self._place = FilePlace(str(path), line)
        self._stem = re.sub(r"[^a-z0-9_]+", "_", path.stem.lower()).strip("_") or "photographs"
        self._line, self._cells, self._pictures, self._report = line, cells, pictures, report
        self._right = True

    def entry(self) -> Entry | None:
        """What the row says; None if anything in it is wrong."""
        files, clip = self._shown()
        options, pictured = self._options()
        frames = self._frames(files[0] if clip and self._right else "", clip)
        answer, number = self._answer(options)
        made = Entry(
            line=self._line,
            task=self._word("task", _NAME, self._stem if _NAME.fullmatch(self._stem) else f"t_{self._stem}"),
            dimension=self._word("dimension", _DIMENSION, "real"),
            name=self._word("name", _NAME, ""),
            episode=self._cell("episode"),
            group=self._cell("group"),
            text=self._filled("question"),
            pictures=files,
            clip=clip,
            frames=frames,
            times=self._times(files, clip),
            options=options,
            pictured=pictured,
            answer=answer,
            value=self._cell("answer"),
            number=number,
            within=self._within(options),
            unit=self._cell("unit"),
            difference=self._number("difference"),
            quantity=self._quantity(),
            source=self._cell("source"),
            license=self._cell("license"),
            factors={n.removeprefix(FACTOR): v for n, v in self._cells.items() if n.startswith(FACTOR)},
        )
        return made if self._right else None

    # ------------------------------------------------------------ cells

    def _cell(self, column: str) -> str:
        return self._cells.get(column, "")

    def _parts(self, column: str) -> tuple[str, ...]:
        return tuple(part.strip() for part in self._cell(column).split(";")) if self._cell(column) else ()

    def _wrong(self, column: str, message: str, remedy: str) -> None:
        self._right = False
        place = replace(self._place, element=f"column `{column}`")
        self._report.include([Diagnostic(message, place, remedy)])

    def _filled(self, column: str) -> str:
        if not self._cell(column):
            self._wrong(column, "it is empty", f"write {COLUMNS[column]}")
        return self._cell(column)

    def _word(self, column: str, pattern: re.Pattern[str], default: str) -> str:
        word = self._cell(column) or default
        if word and not pattern.fullmatch(word):
            self._wrong(column, f"`{word}` is no name", "write small letters, digits and _, such as `left_of`")
        return word

    def _number(self, column: str, text: str | None = None) -> float | None:
        written = self._cell(column) if text is None else text
        if not written:
            return None
        try:
            number = float(written)
        except ValueError:
            number = math.nan
        if not math.isfinite(number):
            self._wrong(column, f"`{written}` is no number", "write it such as 1.5, its unit in the column `unit`")
            return None
        return number

    # ------------------------------------------------------------ pictures

    def _shown(self) -> tuple[tuple[str, ...], bool]:
        names = self._parts("pictures")
        if not names:
            self._wrong("pictures", "it is empty", f"write {COLUMNS['pictures']}")
        clip = any(Path(name).suffix.lower() in CLIPS for name in names) or any(map(self._pictures.moves, names))
        if clip and len(names) > 1:
            self._wrong("pictures", "a clip stands alone", "write one clip, or several photographs")
            return names, True
        for name in names:
            self._open("pictures", name, 1 if clip else None)
        return names, clip

    def _open(self, column: str, name: str, frames: int | None = None) -> None:
        """Open a photograph, or so many pictures of a clip."""
        try:
            if frames is None:
                self._pictures.still(name)
            else:
                self._pictures.frames(name, frames)
        except WmsError as error:
            for diagnostic in error.diagnostics:
                self._wrong(column, diagnostic.message, diagnostic.help)

    def _frames(self, readable: str, clip: bool) -> int:
        """How many pictures are taken from a clip, if it is `readable` (its name, else "")."""
        frames = self._number("frames")
        number = FRAMES if frames is None else frames
        if frames is not None and not clip:
            self._wrong("frames", "there is no clip to take them from", "leave it empty")
        elif number != int(number) or not 1 <= number <= 64:
            self._wrong("frames", f"{number:g} is no number of pictures", "write a whole number from 1 to 64")
        elif readable:
            self._open("frames", readable, int(number))
        return int(number)

    def _times(self, files: tuple[str, ...], clip: bool) -> tuple[float, ...]:
        times = [self._number("times", part) for part in self._parts("times")]
        known = tuple(time for time in times if time is not None)
        if times and clip:
            self._wrong("times", "a clip has its own times", "leave it empty")
        elif times and len(times) != len(files):
            self._wrong("times", f"{len(times)} times for {len(files)} pictures", "write one for each, parted by `;`")
        elif list(known) != sorted(known):
            self._wrong("times", "they do not rise", "write the pictures and their times in order")
        return known or tuple(float(i) for i in range(len(files)))

    # ------------------------------------------------------------ options and answer

    def _options(self) -> tuple[tuple[str, ...], bool]:
        options = self._parts("options")
        files = [o for o in options if Path(o).suffix.lower() in STILLS]
        if options and len(options) < 2:
            self._wrong(
                "options", "there is one alone", "write at least two, parted by `;`, or none for an open question"
            )
        if "" in options:
            self._wrong("options", "one of them is empty", "leave out the `;` too many")
        for option in sorted({o for o in options if o and options.count(o) > 1}):
            self._wrong("options", f"`{option}` is there twice", "leave one of them out")
        if files and len(files) < len(options):
            word = next(o for o in options if o not in files)
            self._wrong("options", f"`{word}` is no photograph, but others are", "write either words or files")
        elif files:
            self._different(options)
        return options, bool(files)

    def _different(self, options: tuple[str, ...]) -> None:
        before = self._report.failed
        for name in options:
            self._open("options", name)
        if before or not self._right:
            return
        first: dict[bytes, str] = {}
        for name in options:
            other = first.setdefault(self._pictures.digest(name), name)
            if other != name:
                self._wrong("options", f"{other} and {name} are the same picture", "leave one of them out")

    def _answer(self, options: tuple[str, ...]) -> tuple[int | None, float | None]:
        value = self._filled("answer")
        if not options:
            return None, self._number("answer")
        if value and value not in options:
            remedy = suggestion(value, options) or "write one of the options as it is written there"
            self._wrong("answer", f"`{value}` is none of the options", remedy)
        return (options.index(value) if value in options else None), None

    def _within(self, options: tuple[str, ...]) -> float | None:
        within = self._number("within")
        if options and within is not None:
            self._wrong("within", "the question has options", "leave it empty")
        elif not options and within is None and self._right:
            self._wrong("within", "it is empty", "write how far off a number is still right, or write options")
        elif within is not None and within < 0:
            self._wrong("within", "it is negative", "write how far off a number is still right")
        return within

    def _quantity(self) -> str:
        if self._cell("difference") and not self._cell("quantity"):
            self._wrong("quantity", "it is empty", "write of what `difference` is the number")
        return self._cell("quantity")
