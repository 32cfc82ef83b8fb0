"""Tables written by people, with one question a row. All errors are reported at once, with row and column."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

from wmspec.core.diagnostics import Report, WmsError, suggestion
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import read_bytes
from wmspec.eval.image_import.decode import CLIP_SUFFIXES, STILL_SUFFIXES, PictureFolder

#: The columns and their descriptions; the first four are required.
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
    "within": "of an open question: the largest error of a right number",
    "source": "where the pictures are from",
    "license": "under which licence they are",
}
REQUIRED_COLUMNS = ("question", "pictures", "options", "answer")
FACTOR_PREFIX = "factor."
#: Default number of pictures from a clip.
DEFAULT_FRAMES = 4

_NAME = re.compile(r"[a-z][a-z0-9_]*")
_DIMENSION = re.compile(r"[a-z][a-z0-9_]*(\.[a-z][a-z0-9_]*)*")


@dataclass(frozen=True)
class Entry:
    """A valid row of the table.

    `line` is its first line. `answer` is the position of the true option, None if the question is open. `pictured`
    means that the options are files. A `clip` yields `frames` pictures.
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


def read(path: Path, pictures: PictureFolder) -> tuple[Entry, ...]:
    """Return the validated rows of a table (CSV in UTF-8), after opening all pictures that they name.

    Raises WmsError with every error: each with its row, its column and a remedy.
    """
    report = Report(WmsError)
    rows = list(_rows(path, report))
    entries = [_Row(path, line, cells, pictures, report).entry() for line, cells in rows]
    _check_repeats(path, [entry for entry in entries if entry], report)
    if not rows and not report.failed:
        report.add("", "the table has no rows", FilePlace(str(path)), "write one question a row below the names")
    report.stop_if_failed()
    return tuple(entry for entry in entries if entry)


def _rows(path: Path, report: Report) -> Iterator[tuple[int, dict[str, str]]]:
    """Yield every row by column, with its first line; none if the header is invalid."""
    try:
        text = read_bytes(path).decode("utf-8-sig")
    except OSError as error:
        raise WmsError(f"cannot be read: {error.strerror}", FilePlace(str(path)), "give a .csv file") from None
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise WmsError("this is not UTF-8", FilePlace(str(path), line), "save the table as CSV in UTF-8") from None
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        head = [name.strip() for name in next(reader, [])]
        if not _check_header(path, head, report):
            return
        line = reader.line_num + 1
        for cells in reader:
            if len(cells) > len(head):
                message = f"the row has {len(cells)} cells, the table {len(head)} columns"
                report.add("", message, FilePlace(str(path), line), 'put a cell with a comma in it in "quotes"')
            elif any(cell.strip() for cell in cells):
                yield line, {name: cell.strip() for name, cell in zip(head, cells, strict=False)}
            line = reader.line_num + 1
    except csv.Error as error:
        place = FilePlace(str(path), reader.line_num)
        report.add("", f"this is not CSV: {error}", place, 'write a quote inside of a quoted cell twice: ""')


def _check_header(path: Path, head: list[str], report: Report) -> bool:
    """Whether all columns are known and all required ones present."""
    place = FilePlace(str(path), 1)
    for name in REQUIRED_COLUMNS:
        if name not in head:
            close = suggestion(name, [n for n in head if n not in COLUMNS and n])
            remedy = f"call it so; it holds {COLUMNS[name]}" + (f"; {close}" if close.startswith("did") else "")
            report.add("", f"there is no column `{name}`", place, remedy)
    for name in sorted({n for n in head if head.count(n) > 1}):
        report.add("", f"there are two columns `{name}`", place, "leave one out")
    for name in head:
        known = name in COLUMNS or (
            name.startswith(FACTOR_PREFIX) and _NAME.fullmatch(name.removeprefix(FACTOR_PREFIX))
        )
        if not known:
            remedy = (
                suggestion(name, COLUMNS) or f"known are {', '.join(COLUMNS)}, and {FACTOR_PREFIX}NAME for what varies"
            )
            report.add("", f"column `{name}` is not known", place, remedy)
    return not report.failed


def _check_repeats(path: Path, entries: list[Entry], report: Report) -> None:
    """Report rows that repeat an earlier question."""
    first: dict[object, int] = {}
    for entry in entries:
        key = (entry.task, entry.text, entry.pictures, frozenset(entry.options))
        if key in first:
            message = f"the row repeats the question of line {first[key]}"
            report.add("", message, FilePlace(str(path), entry.line), "leave one of them out")
        first.setdefault(key, entry.line)


class _Row:
    """A row being validated."""

    def __init__(self, path: Path, line: int, cells: dict[str, str], pictures: PictureFolder, report: Report) -> None:
        self._place = FilePlace(str(path), line)
        self._stem = re.sub(r"[^a-z0-9_]+", "_", path.stem.lower()).strip("_") or "photographs"
        self._line, self._cells, self._pictures, self._report = line, cells, pictures, report
        self._right = True

    def entry(self) -> Entry | None:
        """Return the entry; None if the row has errors."""
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
            factors={n.removeprefix(FACTOR_PREFIX): v for n, v in self._cells.items() if n.startswith(FACTOR_PREFIX)},
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
        self._report.add("", message, place, remedy)

    def _filled(self, column: str) -> str:
        if not self._cell(column):
            self._wrong(column, "it is empty", f"write {COLUMNS[column]}")
        return self._cell(column)

    def _word(self, column: str, pattern: re.Pattern[str], default: str) -> str:
        word = self._cell(column) or default
        if word and not pattern.fullmatch(word):
            self._wrong(column, f"`{word}` is not a name", "write small letters, digits and _, such as `left_of`")
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
            self._wrong(column, f"`{written}` is not a number", "write it such as 1.5, its unit in the column `unit`")
            return None
        return number

    # ------------------------------------------------------------ pictures

    def _shown(self) -> tuple[tuple[str, ...], bool]:
        names = self._parts("pictures")
        if not names:
            self._wrong("pictures", "it is empty", f"write {COLUMNS['pictures']}")
        clip = any(Path(name).suffix.lower() in CLIP_SUFFIXES for name in names) or any(
            map(self._pictures.moves, names)
        )
        if clip and len(names) > 1:
            self._wrong("pictures", "a clip must be the only file", "write one clip, or several photographs")
            return names, True
        for name in names:
            self._check_readable("pictures", name, 1 if clip else None)
        return names, clip

    def _check_readable(self, column: str, name: str, frames: int | None = None) -> None:
        """Open a photograph, or frames of a clip, to report errors."""
        try:
            if frames is None:
                self._pictures.still(name)
            else:
                self._pictures.frames(name, frames)
        except WmsError as error:
            for diagnostic in error.diagnostics:
                self._wrong(column, diagnostic.message, diagnostic.help)

    def _frames(self, readable: str, clip: bool) -> int:
        """Return the number of pictures from a clip, if it is `readable` (its name, else '')."""
        frames = self._number("frames")
        number = DEFAULT_FRAMES if frames is None else frames
        if frames is not None and not clip:
            self._wrong("frames", "there is no clip to take them from", "leave it empty")
        elif number != int(number) or not 1 <= number <= 64:
            self._wrong("frames", f"{number:g} is not a number of pictures", "write a whole number from 1 to 64")
        elif readable:
            self._check_readable("frames", readable, int(number))
        return int(number)

    def _times(self, files: tuple[str, ...], clip: bool) -> tuple[float, ...]:
        times = [self._number("times", part) for part in self._parts("times")]
        known = tuple(time for time in times if time is not None)
        if times and clip:
            self._wrong("times", "a clip has its own times", "leave it empty")
        elif times and len(times) != len(files):
            self._wrong("times", f"{len(times)} times for {len(files)} pictures", "write one for each, parted by `;`")
        elif list(known) != sorted(known):
            self._wrong("times", "the times are not increasing", "write the pictures and their times in order")
        return known or tuple(float(i) for i in range(len(files)))

    # ------------------------------------------------------------ options and answer

    def _options(self) -> tuple[tuple[str, ...], bool]:
        options = self._parts("options")
        files = [o for o in options if Path(o).suffix.lower() in STILL_SUFFIXES]
        if options and len(options) < 2:
            self._wrong(
                "options", "there is only one option", "write at least two, parted by `;`, or none for an open question"
            )
        if "" in options:
            self._wrong("options", "one of them is empty", "leave out the `;` too many")
        for option in sorted({o for o in options if o and options.count(o) > 1}):
            self._wrong("options", f"`{option}` is there twice", "leave one of them out")
        if files and len(files) < len(options):
            word = next(o for o in options if o not in files)
            self._wrong(
                "options", f"`{word}` is not a photograph, but other options are", "write either words or files"
            )
        elif files:
            self._check_different(options)
        return options, bool(files)

    def _check_different(self, options: tuple[str, ...]) -> None:
        before = self._report.failed
        for name in options:
            self._check_readable("options", name)
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
            self._wrong("answer", f"`{value}` is not one of the options", remedy)
        return (options.index(value) if value in options else None), None

    def _within(self, options: tuple[str, ...]) -> float | None:
        within = self._number("within")
        if options and within is not None:
            self._wrong("within", "the question has options", "leave it empty")
        elif not options and within is None and self._right:
            self._wrong("within", "it is empty", "write the largest error of a right number, or write options")
        elif within is not None and within < 0:
            self._wrong("within", "it is negative", "write the largest error of a right number")
        return within

    def _quantity(self) -> str:
        if self._cell("difference") and not self._cell("quantity"):
            self._wrong("quantity", "it is empty", "write the quantity that `difference` measures")
        return self._cell("quantity")
