"""Datasets, traces, results and studies of a hostile author, who signs what is changed, for `hostile_files.py`.

Each starts as a valid one (`benchmarks/damaged.py`) and gets up to three changes: markup and paths in texts, odd
numbers, pictures that are none, files that unpack to more than they seem, links, pipes, and databases with programs.
"""

# ruff: noqa: S608  it writes hostile statements

from __future__ import annotations

import json
import os
import random
import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing, suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from benchmarks.damaged import changed, damaged, instead, originals
from tests.study.visitor import letter
from tests.trust.made import edited, png, resaved, rewritten, signed
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.models import results
from wmspec.eval.study import store
from wmspec.eval.study.answers import Answer, Person, Visit
from wmspec.eval.study.make import StudyOptions, make
from wmspec.eval.study.model import STUDY_FILE, load
from wmspec.eval.study.store import AnswerStore

#: What a page may not execute: scripts set this global name.
CANARY: Final = "canary"
WORDS: Final = (
    f'<img src=x onerror="{CANARY}=1;alert(1)">', f"</script><script>{CANARY}=1</script>", f'"><svg onload={CANARY}=1>',
    f"javascript:{CANARY}=1", "{{ 7*7 }}{% include '/etc/passwd' %}", f"${{{CANARY}=1}}", "\u2028\u202e<!--",
    "\x1b]0;x\x07\x1b[2J", "\0", "x" * 100_000, "../../secret.png", "../../../a/secret.usda", "file:///etc/passwd",
    "https://example.org/x.png", r"\input{/etc/passwd}$x^2$", "=HYPERLINK(1)", f"[x](javascript:{CANARY}=1)", "",
    f"data:text/html,<script>{CANARY}=1</script>", "'; drop table visit; --", "__proto__", "constructor", "]]>",
)  # fmt: skip
SVG: Final = f'<svg xmlns="http://www.w3.org/2000/svg" onload="{CANARY}=1"><script>{CANARY}=1</script></svg>'.encode()
DEEP: Final = b"[" * 100_000


@dataclass
class Case:
    """What is opened: its kind, its path in the folder `home`, and the names of its changes."""

    kind: str
    chance: random.Random
    home: Path
    path: Path
    changes: list[str] = field(default_factory=list)

    def word(self) -> str:
        """Return a text."""
        return self.chance.choice(WORDS)

    def odd(self, value: Any) -> Any:
        """Return another value of the same type, or a text."""
        return self.word() if isinstance(value, str) else instead(value, self.chance)

    def inside(self, value: Any) -> Any:
        """Return JSON with one value changed, at any depth, or with one key."""
        if isinstance(value, dict) and value:
            name = self.chance.choice(sorted(value))
            if self.chance.random() < 0.1:
                return {**value, self.word(): value[name]}
            return {**value, name: self.inside(value[name])}
        if isinstance(value, list) and value and self.chance.random() < 0.8:
            at = self.chance.randrange(len(value))
            return [*value[:at], self.inside(value[at]), *value[at + 1 :]]
        return self.odd(value)


Change = Callable[[Case], None]


def spoiled(number: int, home: Path) -> Case:
    """Make what is opened, a pure function of its number; about a tenth is as it should be."""
    chance = random.Random(f"spoiled {number}")  # noqa: S311
    kind = tuple(KINDS)[number % len(KINDS)]
    begin, changes = KINDS[kind]
    case = Case(kind, chance, home, home / "in")
    begin(case)
    for _ in range(chance.choice((0, 1, 1, 1, 1, 1, 2, 2, 2, 3))):
        change = chance.choice(changes)
        if case.path.is_fifo():  # to read it would take forever
            break
        case.changes.append(change.__name__)
        with suppress(Exception):  # an earlier change is in the way
            change(case)
    return case


def _replaced(case: Case, path: Path) -> None:
    """Put something else in the place of a file."""
    content = path.read_bytes()
    path.unlink()
    match case.chance.randrange(6):
        case 0:
            os.mkfifo(path)
        case 1:
            path.mkdir()
        case 2:
            path.symlink_to(case.chance.choice((path.name, "/dev/zero", "/etc/passwd")))
        case 3:
            path.symlink_to(case.home.parent.parent / "secret.png")
        case 4:
            path.write_bytes(case.chance.choice((b"", DEEP, b'{"a":' * 50_000, b"9" * 50_000, SVG)))
        case _:
            path.write_bytes(damaged(content, case.chance))


# ---------------------------------------------------------------- datasets


def _dataset(case: Case) -> None:
    shutil.copytree(originals() / "dataset", case.path)


def _shard(case: Case) -> str:
    return str(case.chance.choice(sorted(case.path.glob("data/*/*.parquet"))).relative_to(case.path))


def words_of_rows(case: Case) -> None:
    """Texts of all rows, or of one."""

    def change(rows: list[dict[str, Any]]) -> None:
        name = case.chance.choice([name for name, value in rows[0].items() if isinstance(value, str | list)])
        for row in rows if case.chance.random() < 0.5 else rows[:1]:
            row[name] = [case.odd(each) for each in row[name]] if isinstance(row[name], list) else case.word()

    rewritten(case.path, _shard(case), change)


def values_of_rows(case: Case) -> None:
    """A value of a row."""

    def change(rows: list[dict[str, Any]]) -> None:
        row = case.chance.choice(rows)
        name = case.chance.choice(sorted(row))
        row[name] = case.inside(row[name])

    rewritten(case.path, _shard(case), change)


def factors_of_rows(case: Case) -> None:
    """Words of factors, which pages show and filter by."""

    def change(rows: list[dict[str, Any]]) -> None:
        names = [n for n, v in rows[0].items() if n.startswith(("factor.", "nuisance.")) and isinstance(v, str)]
        for row in rows:
            row[case.chance.choice(names)] = case.word()

    rewritten(case.path, _shard(case), change)


def pictures_of_rows(case: Case) -> None:
    """Pictures of other formats, cut off, too large, or with more after their end."""
    large = bytearray(png(8))
    large[16:24] = b"\x00\x01\x00\x00\x00\x01\x00\x00"
    content = case.chance.choice(
        (SVG, b"GIF89a" + bytes(60), png(64)[:-50], bytes(large), png(8) + SVG, b"", png(2000))
    )

    def change(rows: list[dict[str, Any]]) -> None:
        for picture in case.chance.choice(rows)["context"]:
            picture["bytes"] = content

    rewritten(case.path, _shard(case), change)


def manifest(case: Case) -> None:
    """A value, a key or the text of the manifest."""
    path = case.path / "manifest.json"
    match case.chance.randrange(3):
        case 0:
            path.write_bytes(case.chance.choice((damaged, changed))(path.read_bytes(), case.chance))
        case _:
            edited(case.path, lambda value: value.update(case.inside(value)))


def plan_of_dataset(case: Case) -> None:
    """A value of the plan, in which the specs are."""
    path = case.path / "plan.json"
    path.write_text(json.dumps(case.inside(json.loads(path.read_bytes()))))


def _repeated(text: str, count: int) -> pa.Array:
    """Return a column that a file holds once, and a reader unpacks `count` times."""
    return pa.DictionaryArray.from_arrays(pa.array(np.zeros(count, np.int32)), pa.array([text]))


def bomb_of_rows(case: Case) -> None:
    """A small shard that unpacks to much: rows, or a text."""
    name = _shard(case)
    table = pq.read_table(case.path / name)
    if case.chance.random() < 0.5:
        text = case.chance.choice(("x" * 100_000_000, "x" * 1_000_000))
        table = table.set_column(table.column_names.index("text"), "text", _repeated(text, len(table)))
    else:
        table = pa.concat_tables([table.slice(0, 1)] * 20_000).combine_chunks()
        table = table.set_column(table.column_names.index("text"), "text", _repeated("x" * 1_000_000, len(table)))
    pq.write_table(table, case.path / name, compression="zstd")
    signed(case.path, name)


def bytes_of_shard(case: Case) -> None:
    """Damaged bytes of a shard, which the manifest has the hash of."""
    name = _shard(case)
    (case.path / name).write_bytes(damaged((case.path / name).read_bytes(), case.chance))
    signed(case.path, name)


def file_of_dataset(case: Case) -> None:
    """Something else in the place of a file."""
    _replaced(case, case.chance.choice([path for path in sorted(case.path.rglob("*")) if path.is_file()]))


# ---------------------------------------------------------------- traces


def _trace(case: Case) -> None:
    case.path = case.home / "in.npz"
    shutil.copy(originals() / "trace.npz", case.path)


def array(case: Case) -> None:
    """Numbers of an array, its type or its shape."""
    with np.load(case.path) as file:
        name = case.chance.choice(sorted(file.files))
        value = file[name].copy()
    if value.dtype.kind == "f" and value.size and case.chance.random() < 0.6:
        value.flat[case.chance.randrange(value.size)] = case.chance.choice((np.nan, np.inf, -1.0, 1e308, 0.0))
    else:
        others = (value[:0] if value.ndim else value, value.astype("U9"), value[..., None], np.array(7), None)
        value = case.chance.choice((*others, np.array(case.word())))
    resaved(case.path, **{name: value})


def stage_of_trace(case: Case) -> None:
    """The text of its stage."""
    with np.load(case.path) as file:
        text = str(file["stage"])
    odd = case.chance.choice((
        "def Scope \"s\" (references = @../../secret.usda@) {\n}\n", "def \"s\" (payload = @/etc/passwd@) {\n}\n",
        f"def Scope \"s\" (doc = {json.dumps(case.word())}) {{\n}}\n", "def \"n\" {\n" * 4_000 + "}\n" * 4_000,
        "def Shader \"s\" {\nasset inputs:file = @../../secret.png@\n}\n", "\0",
    ))  # fmt: skip
    encoded = text.encode()
    if case.chance.random() < 0.5:
        encoded = case.chance.choice((damaged, changed))(encoded, case.chance)
    else:
        encoded += odd.encode()
    resaved(case.path, stage=np.array(encoded.decode(errors="replace")))


def bomb_of_trace(case: Case) -> None:
    """An array that unpacks to much."""
    with np.load(case.path) as file:
        kept = dict(file)
    kept[case.chance.choice(("position", "time", "extra", "stage"))] = np.zeros(40_000_000)
    np.savez_compressed(case.path, **kept)


def pickled(case: Case) -> None:
    """An array of objects, which only a program can load."""
    resaved(case.path, **{case.chance.choice(("bodies", "more")): np.array([{"a": 1}, print], dtype=object)})


def file_of_trace(case: Case) -> None:
    """Damaged bytes, or something else in its place."""
    _replaced(case, case.path)


# ---------------------------------------------------------------- results


def _results(case: Case) -> None:
    case.path = case.home / "in.parquet"
    for suffix in (".parquet", ".json"):
        shutil.copy((originals() / "results.parquet").with_suffix(suffix), case.path.with_suffix(suffix))


def _rewritten(case: Case, change: Callable[[list[dict[str, Any]], dict[str, Any]], Any]) -> None:
    rows, about = results.read(case.path)
    results.write(case.path, *(change(rows, about) or (rows, about)))


def words_of_replies(case: Case) -> None:
    """A text of all replies: the reply, the model, the task or another."""

    def change(rows: list[dict[str, Any]], _: dict[str, Any]) -> None:
        name, word = (
            case.chance.choice(sorted(n for n, v in rows[0].items() if v is None or isinstance(v, str))),
            case.word(),
        )
        for row in rows:
            row[name] = word

    _rewritten(case, change)


def values_of_replies(case: Case) -> None:
    """Values of one reply."""

    def change(rows: list[dict[str, Any]], _: dict[str, Any]) -> None:
        row = case.chance.choice(rows)
        for _time in range(case.chance.choice((1, 2, 5))):
            name = case.chance.choice(sorted(row))
            row[name] = case.inside(row[name])

    _rewritten(case, change)


def number_of_replies(case: Case) -> None:
    """No replies, the same again, or those of many models."""

    def change(rows: list[dict[str, Any]], about: dict[str, Any]) -> Any:
        more = [{**row, "model": f"m{n}"} for n in range(25) for row in rows]
        return case.chance.choice(([], rows * 3, rows[:1], more)), about

    _rewritten(case, change)


def settings(case: Case) -> None:
    """The settings in the file and beside it."""
    _rewritten(case, lambda rows, about: (rows, case.inside(about)))
    beside = case.path.with_suffix(".json")
    if case.chance.random() < 0.5:
        _replaced(case, beside)


def schema_of_replies(case: Case) -> None:
    """Columns of other types, absent, doubled or nested."""
    table = pq.read_table(case.path)
    name = case.chance.choice(table.column_names)
    place = table.column_names.index(name)
    column = case.chance.choice((
        pa.array(["x"] * len(table)), pa.array([1e308] * len(table)), pa.array([[[{"a": None}]]] * len(table)),
        pa.nulls(len(table)), pa.array([b"\xff"] * len(table)), pa.array(["x"] * len(table)).dictionary_encode(),
    ))  # fmt: skip
    table = case.chance.choice(
        (table.drop_columns([name]), table.set_column(place, name, column), table.append_column(name, column))
    )
    pq.write_table(table, case.path)


def bomb_of_replies(case: Case) -> None:
    """A small file that unpacks to much: replies, or a text."""
    table = pq.read_table(case.path)
    if case.chance.random() < 0.5:
        text = case.chance.choice(("7 " * 50_000_000, "7 " * 1_000_000))
        table = table.set_column(table.column_names.index("text"), "text", _repeated(text, len(table)))
    else:
        table = pa.concat_tables([table.slice(0, 1)] * case.chance.choice((2_000, 100_000))).combine_chunks()
        if case.chance.random() < 0.7:
            table = table.set_column(table.column_names.index("text"), "text", _repeated("x" * 1_000_000, len(table)))
    pq.write_table(table, case.path, compression="zstd")


def file_of_results(case: Case) -> None:
    """Damaged bytes, or something else in its place."""
    _replaced(case, case.path)


# ---------------------------------------------------------------- studies


@cache
def _studied() -> Path:
    """Return a study with the answers of one person in its database, and of another in a file beside it."""
    folder = originals() / "study"
    study = make(DatasetReader.open(originals() / "dataset"), StudyOptions(per_task=2, raters=2, check_every=2), folder)
    kept = AnswerStore(folder / store.ANSWERS_FILE, study)
    person = Person(session="0" * 32, rater="anne")
    slot = kept.begin(person).slot
    given = tuple(Answer(step=n, text=letter(study, slot, n), seconds=2.0) for n in range(len(study.slots[slot])))
    for answer in given:
        kept.keep(person.session, answer)
    kept.close()
    saved = Visit(session="1" * 32, study=study.fingerprint, slot=slot, answers=given)
    (folder / "ben.json").write_text(saved.model_dump_json())
    return folder


def _study(case: Case) -> None:
    shutil.copytree(_studied(), case.path)


def _database(case: Case) -> closing[sqlite3.Connection]:
    return closing(sqlite3.connect(case.path / store.ANSWERS_FILE, timeout=1, isolation_level=None))


def values_of_database(case: Case) -> None:
    """Values that no server stores, in tables without types."""
    table, name = case.chance.choice((
        ("visit", "session"), ("visit", "rater"), ("visit", "slot"), ("visit", "code"), ("visit", "study_id"),
        ("answer", "session"), ("answer", "step"), ("answer", "text"), ("answer", "seconds"), ("answer", "away"),
    ))  # fmt: skip
    value = case.chance.choice((case.word(), -1, 2**62, 10**6, 1e308, float("inf"), None, b"\xff\x00", 0.5, "7"))
    with _database(case) as file:
        file.executescript(
            f"create table copy as select * from {table}; drop table {table}; alter table copy rename to {table}"
        )
        file.execute(f"update {table} set {name} = ?", [value])


#: A query without an end, one with many numbers, and programs in place of tables.
ENDLESS: Final = "(with recursive n(x) as (select 1 union all select x + 1 from n) select x from n)"
MANY: Final = "(with recursive n(x) as (select 1 union all select x + 1 from n where x < 300000) select x from n)"
PROGRAMS: Final = (
    f"""drop table visit; create view visit as select x as session, '' as rater, 0 as slot, '' as code, '' as began,
    '' as study_id, '' as session_id from {ENDLESS}""",
    f"""drop table answer; create view answer as select '' as session, x as step, 'A' as text, 1 as seconds, 0 as away
    from {ENDLESS}""",
    f"drop table study; create view study as select x as fingerprint from {ENDLESS}",
    f"create trigger t before insert on visit begin select count(*) from {ENDLESS}; end",
    f"create trigger t after insert on answer begin select count(*) from {ENDLESS}; end",
    "drop table visit; create virtual table visit using fts5(session, rater, slot, code, began)",
    "alter table visit add column more as (hex(zeroblob(900000000)))",
    "create table more as select hex(zeroblob(20000000)) as x",
    "create unique index i on visit (length(hex(zeroblob(200000000))))",
)
#: Many rows, none, or those of another study.
ROWS: Final = (
    f"""insert into visit (session, rater, slot, code, began)
    select printf('%032x', x + 9), 'r' || x, x % 2, 'c', '' from {MANY}""",
    f"insert into answer select printf('%032x', 0), x + 99, 'A', 1.0, 0.0, '' from {MANY}",
    "insert into study values ('another')",
    "delete from study",
    "delete from visit",
    "drop table answer",
)


def programs_of_database(case: Case) -> None:
    """Views, triggers, virtual tables and computed columns, most without an end."""
    with _database(case) as file:
        file.executescript(case.chance.choice(PROGRAMS))


def rows_of_database(case: Case) -> None:
    """Many visits or answers, or another study."""
    with _database(case) as file:
        file.executescript(case.chance.choice(ROWS))


def study_json(case: Case) -> None:
    """A value of the study, whose database is signed with it."""
    path = case.path / STUDY_FILE
    if case.chance.random() < 0.3:
        path.write_bytes(case.chance.choice((damaged, changed))(path.read_bytes(), case.chance))
    else:
        path.write_text(json.dumps(case.inside(json.loads(path.read_bytes()))))
    with _database(case) as file:
        file.execute("update study set fingerprint = ?", [load(case.path).fingerprint])


def texts_of_study(case: Case) -> None:
    """A text that the page shows."""
    path = case.chance.choice(sorted((case.path / "texts").iterdir()))
    content = path.read_bytes()
    if path.suffix == ".txt":
        path.write_text("\n\n".join(case.word() for _ in range(3)))
    else:
        quoted = json.dumps(case.word(), ensure_ascii=False).encode()
        path.write_bytes(case.chance.choice((changed(content, case.chance), content.replace(b'"en"', quoted))))


def answers_of_file(case: Case) -> None:
    """A value of the answers in a file."""
    path = case.path / "ben.json"
    path.write_text(json.dumps(case.inside(json.loads(path.read_bytes()))))


def file_of_study(case: Case) -> None:
    """Something else in the place of a file."""
    _replaced(case, case.chance.choice([path for path in sorted(case.path.rglob("*")) if path.is_file()]))


KINDS: Final[dict[str, tuple[Change, tuple[Change, ...]]]] = {
    "dataset": (_dataset, (
        words_of_rows, words_of_rows, factors_of_rows, values_of_rows, pictures_of_rows, manifest, manifest,
        plan_of_dataset, bomb_of_rows, bytes_of_shard, file_of_dataset,
    )),
    "trace": (_trace, (array, array, stage_of_trace, stage_of_trace, bomb_of_trace, pickled, file_of_trace)),
    "results": (_results, (
        words_of_replies, words_of_replies, values_of_replies, number_of_replies, settings, settings, schema_of_replies,
        bomb_of_replies, file_of_results,
    )),
    "study": (_study, (
        values_of_database, values_of_database, programs_of_database, programs_of_database, rows_of_database,
        study_json, texts_of_study, answers_of_file, file_of_study,
    )),
}  # fmt: skip
