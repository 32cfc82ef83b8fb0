"""A spec that is checked and drawn whenever its file is saved."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from threading import Condition, Event
from typing import Literal

from wmspec.api.loading import TextCheck
from wmspec.api.task import Task
from wmspec.core.diagnostics import Diagnostic, Report, WmsError
from wmspec.core.places import Source
from wmspec.core.safe_io import read_bytes
from wmspec.editor import examples
from wmspec.lang.parse.files import display_path, read_source
from wmspec.lang.parse.load import load_source
from wmspec.runtime.workers.pool import HelperProcess, JobFailure

#: The interval between polls, and the time limit of an instance, in seconds.
POLL_INTERVAL, INSTANCE_TIMEOUT = 0.2, 60.0


@dataclass(frozen=True)
class PreviewOptions:
    """The engine, the instances per task, and the width of a picture in pixels."""

    engine: str
    instances: int = 3
    size: int = 128


@dataclass(frozen=True)
class State:
    """The state of the page: previews of the current text, or of the last one without mistakes (`stale`)."""

    version: int = 0
    phase: Literal["checking", "drawing", "done"] = "checking"
    diagnostics: tuple[Diagnostic, ...] = ()
    tasks: tuple[tuple[str, int], ...] = ()
    rows: tuple[examples.Row, ...] = ()
    stale: bool = False


@dataclass
class Watch:
    """Polls a spec and its libraries; `state` is always complete, and waiting readers are notified of each new one."""

    path: Path
    options: PreviewOptions
    state: State = field(default_factory=State)
    stopped: Event = field(default_factory=Event)
    _before: tuple[examples.Row, ...] = ()
    _updated: Condition = field(default_factory=Condition)

    def run(self) -> None:
        """Check and draw at every change, until stopped."""
        helper = HelperProcess(INSTANCE_TIMEOUT)
        before: dict[Path, bytes] | None = None
        libraries: tuple[Path, ...] = ()
        try:
            while not self.stopped.is_set():
                now = _contents((self.path, *libraries))
                if now != before:
                    before = now
                    libraries = self._changed(helper, before)
                    before |= _contents(libraries)
                self.stopped.wait(POLL_INTERVAL)
        finally:
            helper.close()

    def stop(self) -> None:
        """End `run` and release waiting readers."""
        self.stopped.set()
        with self._updated:
            self._updated.notify_all()

    def after(self, version: int, timeout: float) -> State | None:
        """Wait for a state newer than `version`; None if there is none within `timeout` seconds."""
        with self._updated:
            self._updated.wait_for(lambda: self.state.version > version or self.stopped.is_set(), timeout)
            return self.state if self.state.version > version else None

    def png(self, name: str) -> bytes | None:
        """Return a picture by name, of the current or the previous previews, which a page may still request."""
        return next(
            (c.png for c in _cells((*self.state.rows, *self._before)) if c.png and picture_name(c.png) == name), None
        )

    def _publish(self, state: State) -> None:
        with self._updated:
            self.state = replace(state, version=self.state.version + 1)
            self._updated.notify_all()

    def _changed(self, helper: HelperProcess, contents: dict[Path, bytes]) -> tuple[Path, ...]:
        """Check the text, then draw it. Returns its libraries."""
        self._before = last = self.state.rows
        self._publish(replace(self.state, phase="checking", stale=bool(last)))
        try:
            text = read_source(self.path).text
            check = TextCheck(text, self.path)
            diagnosis = check.diagnosis()
            tasks = check.tasks if diagnosis.passed else ()
        except WmsError as error:
            self._publish(State(phase="done", diagnostics=error.diagnostics, rows=last, stale=bool(last)))
            return ()
        checked = State(
            phase="drawing", diagnostics=diagnosis.diagnostics, tasks=diagnosis.tasks, rows=last, stale=True
        )
        if not tasks:
            self._publish(replace(checked, phase="done", stale=bool(last)))
            return self._libraries(text)
        self._publish(checked)
        self._draw(helper, text, tasks, checked, contents)
        return tuple(path for task in tasks for path in task.libraries)

    def _libraries(self, text: str) -> tuple[Path, ...]:
        """Return the libraries of a text with mistakes: one of them may contain these."""
        with suppress(WmsError):
            return tuple(load_source(Source(display_path(self.path), text), self.path.parent, Report()).libraries)
        return ()

    def _draw(
        self, helper: HelperProcess, text: str, tasks: tuple[Task, ...], checked: State, contents: dict[Path, bytes]
    ) -> None:
        """Draw instance by instance, until the text changes."""
        rows: tuple[examples.Row, ...] = ()
        helper.do(examples.changed)
        for task, index in _chosen(tasks, self.options.instances):
            if self.stopped.is_set() or _contents((self.path,)) != {self.path: contents[self.path]}:
                return
            row = helper.do(
                examples.draw, text, self.path.resolve(), task.name, index, self.options.engine, self.options.size
            )
            if isinstance(row, JobFailure):
                row = examples.Row(
                    task.name, index, str(task[index]), (examples.QuestionPreview("", rejected=row.reason),)
                )
            rows = (*rows, row)
            self._publish(replace(checked, rows=rows, stale=False))
        self._publish(replace(checked, phase="done", rows=rows, stale=False))


def picture_name(png: bytes) -> str:
    """Return the name of a picture, a hash of its bytes."""
    return hashlib.sha256(png).hexdigest()[:20]


def _chosen(tasks: tuple[Task, ...], count: int) -> Iterator[tuple[Task, int]]:
    """Yield the instances to draw; the same as long as the design is the same."""
    for task in tasks:
        for instance in sorted(task.design.sample(count)):
            yield task, instance


def _cells(rows: tuple[examples.Row, ...]) -> Iterator[examples.Cell]:
    for row in rows:
        for each in row.questions:
            yield from (*each.context, *each.options)


def _contents(paths: tuple[Path, ...]) -> dict[Path, bytes]:
    """Return the contents of files; empty for unreadable ones."""
    contents = {}
    for path in paths:
        try:
            contents[path] = read_bytes(path)
        except OSError:
            contents[path] = b""
    return contents
