"""The replies of a run that is not over, on disk as soon as they come: killed at any moment, none is lost or doubled.

A file of JSON lines that only grows. The first line says what is asked, each other is a reply; a line that a kill cut
off is taken back when the file is opened again. Of an asking that has several replies the last one counts.
"""

from __future__ import annotations

import fcntl
import json
import os
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import Any

from pydantic import TypeAdapter, ValidationError

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import make_folders
from wmspec.dataset.build.files import explained
from wmspec.eval.models.model import Reply

Key = tuple[str, int, int]
Replies = dict[Key, Reply]
_KEY = TypeAdapter(Key)
_REPLY = TypeAdapter(Reply)


class Journal:
    """An open journal; `replies` are those that it had when it was opened."""

    def __init__(self, path: Path, asked: dict[str, Any]) -> None:
        """Open a journal, or begin one, for what is `asked`; no other process can while it is open.

        Raises WmsError if it is of something else, open elsewhere, or cannot be written.
        """
        self.path = path
        with explained(path):
            make_folders(path.parent)
            self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o666)
            try:
                self._lock()
                self.replies = self._read(asked)
            except BaseException:
                os.close(self._file)
                raise

    def __enter__(self) -> Journal:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        os.close(self._file)

    def _lock(self) -> None:
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise WmsError(f"another process is writing to {self.path}; wait for it, or choose another -o") from None

    def _read(self, asked: dict[str, Any]) -> Replies:
        content = self.path.read_bytes()
        whole = content[: content.rfind(b"\n") + 1]
        if len(whole) < len(content):
            os.ftruncate(self._file, len(whole))
        if not whole:
            self._append({"asked": asked})
            return {}
        head, *lines = whole.splitlines()
        same(_loaded(head, self.path).get("asked"), asked, self.path)
        return dict(_record(_loaded(line, self.path), self.path) for line in lines)

    def keep(self, key: Key, reply: Reply) -> None:
        """Write a reply down; when this returns it outlasts a kill and a power cut. Raises WmsError if it cannot."""
        id, permutation, sample = key
        with explained(self.path):
            self._append({"id": id, "permutation": permutation, "sample": sample, **asdict(reply)})

    def _append(self, value: dict[str, Any]) -> None:
        line = json.dumps(value, ensure_ascii=True).encode() + b"\n"
        while line:
            line = line[os.write(self._file, line) :]
        os.fsync(self._file)

    def discard(self) -> None:
        """Remove the file: what it holds is elsewhere."""
        with explained(self.path):
            self.path.unlink()


def same(before: Any, asked: dict[str, Any], path: Path) -> None:
    """Raises WmsError, which names what differs, if results at `path` are not of what is `asked`."""
    before = before if isinstance(before, dict) else {}
    differing = [key for key in asked if before.get(key) != asked[key]]
    if differing:
        raise WmsError(
            f"{path} holds replies to something else: {', '.join(differing)} differ; choose another -o, or move it away"
        )


def _loaded(line: bytes, path: Path) -> dict[str, Any]:
    try:
        value = json.loads(line)
    except (ValueError, RecursionError):
        value = None
    if not isinstance(value, dict):
        raise _other(path)
    return value


def _record(value: dict[str, Any], path: Path) -> tuple[Key, Reply]:
    try:
        key = (value.pop("id"), value.pop("permutation"), value.pop("sample"))
        return _KEY.validate_python(key, strict=True), _REPLY.validate_python(asdict(Reply(**value)))
    except (KeyError, TypeError, ValidationError):
        raise _other(path) from None


def _other(path: Path) -> WmsError:
    what = "no journal of this version of `wmspec evaluate`"
    return WmsError(what, FilePlace(str(path)), "choose another -o, or move it away")
