"""The answers of a served study: an SQLite file with durable, atomic writes."""

from __future__ import annotations

import secrets
import sqlite3
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import monotonic

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import regular_file
from wmspec.eval.study.answers import Answer, Person, Visit
from wmspec.eval.study.model import Study

#: Its name in the study's folder.
ANSWERS_FILE = "answers.sqlite"
#: Maximum number of visits, so that a flood cannot fill the disk.
MAX_VISITS = 20_000

_TABLES = """
create table if not exists study (fingerprint text primary key);
create table if not exists visit (
  session text primary key, rater text not null, slot integer not null, code text not null, began text not null
);
create table if not exists answer (
  session text not null references visit, step integer not null, text text not null,
  seconds real not null, away real not null, at text not null, primary key (session, step)
) without rowid;
"""
#: Maximum size of a value (bytes), and of the time of a transaction (s): a file may hold programs that have no end.
MAX_VALUE_BYTES, MAX_SECONDS = 1 << 20, 30.0
#: Instructions of SQLite between looks at the clock.
_INSTRUCTIONS = 100_000
#: Finds programs in place of tables, and values that no server stores.
_PROGRAMS = """
select name from sqlite_master where type in ('view', 'trigger') or sql like 'create virtual%' or
(type = 'index' and sql is not null)
union all select info.name from sqlite_master as made, pragma_table_xinfo(made.name) as info
where made.type = 'table' and info.hidden
"""
_FOREIGN_VALUES = """
select 'visit' from visit where typeof(session) <> 'text' or typeof(rater) <> 'text' or typeof(code) <> 'text' or
typeof(slot) <> 'integer' or slot not between 0 and ? - 1
union all select 'answer' from answer where typeof(session) <> 'text' or typeof(step) <> 'integer'
"""
#: Further columns of `visit`, which files of earlier versions lack.
_ADDED = ("study_id", "session_id")


@dataclass(frozen=True)
class Progress:
    """The progress of a visit: its slot, the answered steps, and the completion code."""

    slot: int
    done: tuple[int, ...]
    code: str | None


class StudyFull(Exception):
    """All slots are taken."""


class AnswerStore:
    """The open file; thread-safe."""

    def __init__(self, path: Path, study: Study, shares: int | None = None) -> None:
        """Open or create the file; new people get one of the first `shares` slots (None: all).

        Raises WmsError if the file belongs to another study, or cannot be written.
        """
        self._study, self._lock, self._shares = study, threading.Lock(), shares
        self._began = monotonic()
        try:
            # Wait for other processes; a commit is durable when it returns.
            self._file = sqlite3.connect(
                regular_file(path, new=True), timeout=30, isolation_level=None, check_same_thread=False
            )
            self._file.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MAX_VALUE_BYTES)
            self._file.set_progress_handler(self._is_late, _INSTRUCTIONS)
            self._file.execute("pragma trusted_schema=off")
            self._file.execute("pragma synchronous=full")
            self._file.execute("pragma secure_delete=on")  # who withdraws leaves nothing behind
            with self._write():
                if found := self._file.execute(_PROGRAMS).fetchone():
                    raise sqlite3.DatabaseError(f"it has the program `{found[0]}`")
                for statement in filter(str.strip, _TABLES.split(";")):
                    self._file.execute(statement)
                present = {column[1] for column in self._file.execute("pragma table_info(visit)")}
                for column in (name for name in _ADDED if name not in present):
                    self._file.execute(f"alter table visit add column {column} text not null default ''")
                known = [name for (name,) in self._file.execute("select fingerprint from study")]
                if not known:
                    self._file.execute("insert into study values (?)", [study.fingerprint])
                mine = known in ([], [study.fingerprint])
                if mine and (found := self._file.execute(_FOREIGN_VALUES, [len(study.slots)]).fetchone()):
                    raise sqlite3.DatabaseError(f"its table `{found[0]}` has values of no server")
        except (OSError, sqlite3.Error) as error:
            raise WmsError(
                f"cannot be opened ({error})", FilePlace(str(path)), "move it away to start a new file"
            ) from None
        if known and known != [study.fingerprint]:
            raise WmsError("answers to another study", FilePlace(str(path)), "serve the folder that it was made in")

    @contextmanager
    def _write(self) -> Iterator[None]:
        """Run an exclusive transaction."""
        with self._lock:
            self._began = monotonic()
            self._file.execute("begin immediate")
            try:
                yield
            except BaseException:
                self._file.execute("rollback")
                raise
            self._file.execute("commit")

    def _is_late(self) -> bool:
        return monotonic() > self._began + MAX_SECONDS

    def close(self) -> None:
        """Close the file."""
        with self._lock:
            self._file.close()

    def begin(self, person: Person) -> Progress:
        """Return a participant's progress, with a new slot on the first visit.

        Raises StudyFull if all slots are finished.
        """
        with self._write():
            if self._slot(person.session) is None:
                values = [person.session, person.rater, self._free_slot(), secrets.token_hex(4).upper()]
                values += [person.study_id, person.session_id]
                self._file.execute("insert into visit values (?, ?, ?, ?, datetime('now'), ?, ?)", values)
            return self._progress(person.session)

    def keep(self, session: str, answer: Answer) -> Progress | None:
        """Save an answer durably; the first one to a step counts.

        Returns None if there is no such visit or step, or if the answer is invalid.
        """
        with self._write():
            slot = self._slot(session)
            shown = None if slot is None else self._study.step(slot, answer.step)
            if shown is None or not answer.fits(shown[0]):
                return None
            self._file.execute(
                "insert into answer values (?, ?, ?, ?, ?, datetime('now')) on conflict do nothing",
                [session, answer.step, answer.text, answer.seconds, answer.away],
            )
            return self._progress(session)

    def withdraw(self, session: str) -> bool:
        """Delete a visit and its answers, so that its slot is free again. Returns whether there was such a visit."""
        with self._write():
            self._file.execute("delete from answer where session = ?", [session])
            return self._file.execute("delete from visit where session = ?", [session]).rowcount > 0

    def visits(self) -> list[Visit]:
        """Return all visits with their answers, in order of their beginning."""
        with self._lock:
            self._began = monotonic()
            answers: dict[str, list[Answer]] = {}
            for session, step, text, seconds, away in self._file.execute(
                "select session, step, text, seconds, away from answer order by session, step"
            ):
                answers.setdefault(session, []).append(Answer(step=step, text=text, seconds=seconds, away=away))
            rows = self._file.execute(
                "select session, rater, slot, code, study_id, session_id from visit order by rowid"
            )
            names = [name for name, *_ in rows.description]
            visits = [dict(zip(names, row, strict=True)) for row in rows]
        study = self._study.fingerprint
        return [Visit(**visit, study=study, answers=tuple(answers.get(visit["session"], ()))) for visit in visits]

    def _slot(self, session: str) -> int | None:
        row = self._file.execute("select slot from visit where session = ?", [session]).fetchone()
        return None if row is None else int(row[0])

    def _free_slot(self) -> int:
        """Return the least taken of the unfinished slots. Raises Full if there is none."""
        taken: dict[int, int] = dict.fromkeys(range(len(self._study.slots[: self._shares])), 0)
        for slot, count in self._file.execute(
            "select slot, (select count(*) from answer where answer.session = visit.session) from visit"
        ):
            if count == len(self._study.slots[slot]):
                taken.pop(slot, None)
            elif slot in taken:
                taken[slot] += 1
        if not taken or self._file.execute("select count(*) from visit").fetchone()[0] >= MAX_VISITS:
            raise StudyFull
        return min(taken, key=lambda slot: (taken[slot], slot))

    def _progress(self, session: str) -> Progress:
        slot, code = self._file.execute("select slot, code from visit where session = ?", [session]).fetchone()
        done = self._file.execute("select step from answer where session = ? order by step", [session]).fetchall()
        whole = len(done) == len(self._study.slots[slot])
        return Progress(slot, tuple(step for (step,) in done), code if whole else None)
