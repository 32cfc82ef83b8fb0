"""A spec that is checked and drawn whenever its file is saved: what is known of it, and who is told."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from threading import Condition, Event
from typing import Literal

from wmspec.api.loading import diagnose_text
from wmspec.api.task import Task
from wmspec.core.diagnostics import Diagnostic, Report, WmsError
from wmspec.core.places import Source
from wmspec.editor import examples
from wmspec.lang.parse.files import read_source, shown
from wmspec.lang.parse.load import load_source
from wmspec.runtime.workers.pool import Helper, Lost

#: How often the files are looked at (s), and how long one instance may take.
PERIOD, PATIENCE = 0.2, 60.0


@dataclass(frozen=True)
class Drawing:
    """How a sheet is drawn: the engine, the instances of each task, the width of a picture (px)."""

    engine: str
    instances: int = 3
    size: int = 128


@dataclass(frozen=True)
class State:
    """What the page shows: rows of the text as it is, or, while that is broken, of the last one that was not."""

    version: int = 0
    phase: Literal["checking", "drawing", "done"] = "checking"
    diagnostics: tuple[Diagnostic, ...] = ()
    tasks: tuple[tuple[str, int], ...] = ()
    rows: tuple[examples.Row, ...] = ()
    stale: bool = False
    trouble: str = ""


@dataclass
class Watch:
    """Looks at a spec's file and its libraries; `state` is always a whole one, and who waits is told of the next."""

    path: Path
    drawing: Drawing
    state: State = field(default_factory=State)
    stopped: Event = field(default_factory=Event)
    _before: tuple[examples.Row, ...] = ()
    _news: Condition = field(default_factory=Condition)

    def run(self) -> None:
        """Check and draw at every change, until it is stopped."""
        helper = Helper(PATIENCE)
        before: dict[Path, bytes] | None = None
        libraries: tuple[Path, ...] = ()
        try:
            while not self.stopped.is_set():
                now = _contents((self.path, *libraries))
                if now != before:
                    before = now
                    libraries = self._changed(helper, before)
                    before |= _contents(libraries)
                self.stopped.wait(PERIOD)
        finally:
            helper.close()

    def stop(self) -> None:
        """End `run`, and let go of those who wait."""
        self.stopped.set()
        with self._news:
            self._news.notify_all()

    def after(self, version: int, timeout: float) -> State | None:
        """A state newer than `version`, as soon as there is one; None if there is none in `timeout` seconds."""
        with self._news:
            self._news.wait_for(lambda: self.state.version > version or self.stopped.is_set(), timeout)
            return self.state if self.state.version > version else None

    def png(self, name: str) -> bytes | None:
        """A picture of the sheet by its name, or of the one before, which a page may still be asking for."""
        return next(
            (c.png for c in _cells((*self.state.rows, *self._before)) if c.png and picture_name(c.png) == name), None
        )

    def _say(self, state: State) -> None:
        with self._news:
            self.state = replace(state, version=self.state.version + 1)
            self._news.notify_all()

    def _changed(self, helper: Helper, contents: dict[Path, bytes]) -> tuple[Path, ...]:
        """Check the text, then draw it. Returns the libraries that it uses."""
        self._before = last = self.state.rows
        self._say(replace(self.state, phase="checking", stale=bool(last)))
        try:
            text = read_source(self.path).text
            diagnosis, tasks = diagnose_text(text, self.path)
        except WmsError as error:
            self._say(State(phase="done", diagnostics=error.diagnostics, rows=last, stale=bool(last)))
            return ()
        told = State(phase="drawing", diagnostics=diagnosis.diagnostics, tasks=diagnosis.tasks, rows=last, stale=True)
        if not tasks:
            self._say(replace(told, phase="done", stale=bool(last)))
            return self._libraries(text)
        self._say(told)
        self._draw(helper, text, tasks, told, contents)
        return tuple(path for task in tasks for path in task.program.libraries)

    def _libraries(self, text: str) -> tuple[Path, ...]:
        """Those of a text that has mistakes, whatever is in the file by now: one of them may be where these are."""
        with suppress(WmsError):
            return tuple(load_source(Source(shown(self.path), text), self.path.parent, Report()).libraries)
        return ()

    def _draw(
        self, helper: Helper, text: str, tasks: tuple[Task, ...], told: State, contents: dict[Path, bytes]
    ) -> None:
        """Draw instance by instance; a newer text ends it."""
        rows: tuple[examples.Row, ...] = ()
        helper.do(examples.changed)
        for task, index in _chosen(tasks, self.drawing.instances):
            if self.stopped.is_set() or _contents((self.path,)) != {self.path: contents[self.path]}:
                return
            row = helper.do(
                examples.draw, text, self.path.resolve(), task.name, index, self.drawing.engine, self.drawing.size
            )
            if isinstance(row, Lost):
                row = examples.Row(task.name, index, str(task[index]), (examples.Asked("", rejected=row.reason),))
            rows = (*rows, row)
            self._say(replace(told, rows=rows, stale=False))
        self._say(replace(told, phase="done", rows=rows, stale=False))


def picture_name(png: bytes) -> str:
    """What a picture is called: the same one always the same."""
    return hashlib.sha256(png).hexdigest()[:20]


def _chosen(tasks: tuple[Task, ...], count: int) -> Iterator[tuple[Task, int]]:
    """The same instances after every change that leaves the design as it is."""
    for task in tasks:
        for instance in sorted(task.design.sample(count)):
            yield task, instance


def _cells(rows: tuple[examples.Row, ...]) -> Iterator[examples.Cell]:
    for row in rows:
        for asked in row.asked:
            yield from (*asked.shown, *asked.options)


def _contents(paths: tuple[Path, ...]) -> dict[Path, bytes]:
    """What the files hold; nothing for one that cannot be read."""
    contents = {}
    for path in paths:
        try:
            contents[path] = path.read_bytes()
        except OSError:
            contents[path] = b""
    return contents
