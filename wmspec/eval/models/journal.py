"""Journal of an unfinished run: every reply is on disk as soon as it arrives, and none is lost or duplicated.

An append-only file of JSON lines. The first line holds the settings of the run, each other line a reply. A truncated
last line is dropped when the file is opened. If an ask has several replies, the last one counts.
"""

from __future__ import annotations

import fcntl
import json
import os
from dataclasses import asdict
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import make_folders, read_bytes, regular_file
from wmspec.dataset.build.files import with_remedies
from wmspec.eval.models.model import Reply

Key = tuple[str, int, int]
Replies = dict[Key, Reply]
_KEY = TypeAdapter(Key)
_REPLY = TypeAdapter(Reply)


class Journal:
    """An open journal; `replies` are those found when it was opened."""

    def __init__(self, path: Path, settings: dict[str, Any]) -> None:
        """Open or create a journal for the run `settings`, with an exclusive lock.

        Raises WmsError if it belongs to another run, is open elsewhere, or cannot be written.
        """
        self.path = path
        with with_remedies(path):
            make_folders(path.parent)
            self._file = os.open(regular_file(path, new=True), os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o666)
            try:
                self._lock()
                self.replies = self._read(settings)
            except BaseException:
                os.close(self._file)
                raise

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *why: object) -> None:
        os.close(self._file)

    def _lock(self) -> None:
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise WmsError(f"another process is writing to {self.path}; wait for it, or choose another -o") from None

    def _read(self, settings: dict[str, Any]) -> Replies:
        content = read_bytes(self.path)
        whole = content[: content.rfind(b"\n") + 1]
        if len(whole) < len(content):
            os.ftruncate(self._file, len(whole))
        if not whole:
            self._append({"asked": settings})
            return {}
        head, *lines = whole.splitlines()
        require_same_settings(_parse_line(head, self.path).get("asked"), settings, self.path)
        return dict(_record(_parse_line(line, self.path), self.path) for line in lines)

    def keep(self, key: Key, reply: Reply) -> None:
        """Append a reply and flush it to disk. Raises WmsError if that fails."""
        id, permutation, sample = key
        with with_remedies(self.path):
            self._append({"id": id, "permutation": permutation, "sample": sample, **asdict(reply)})

    def _append(self, value: dict[str, Any]) -> None:
        line = json.dumps(value, ensure_ascii=True).encode() + b"\n"
        while line:
            line = line[os.write(self._file, line) :]
        os.fsync(self._file)

    def discard(self) -> None:
        """Remove the file after its replies have been saved elsewhere."""
        with with_remedies(self.path):
            self.path.unlink()


def require_same_settings(before: Any, settings: dict[str, Any], path: Path) -> None:
    """Raise WmsError, with the differences, if results at `path` belong to another run than `settings`."""
    before = before if isinstance(before, dict) else {}
    differing = [key for key in settings if before.get(key) != settings[key]]
    if differing:
        raise WmsError(
            f"{path} holds replies of another run: {', '.join(differing)} differ; choose another -o, or move it away"
        )


def _parse_line(line: bytes, path: Path) -> dict[str, Any]:
    try:
        value = json.loads(line)
    except (ValueError, RecursionError):
        value = None
    if not isinstance(value, dict):
        raise _wrong_version(path)
    return value


def _record(value: dict[str, Any], path: Path) -> tuple[Key, Reply]:
    try:
        if value.pop("outcome", "ok") == "refused":  # written by earlier versions
            value["finish"] = "content_filter"
        key = (value.pop("id"), value.pop("permutation"), value.pop("sample"))
        return _KEY.validate_python(key, strict=True), _REPLY.validate_python(asdict(Reply(**value)))
    except (KeyError, TypeError, ValidationError):
        raise _wrong_version(path) from None


def _wrong_version(path: Path) -> WmsError:
    what = "no journal of this version of `wmspec evaluate`"
    return WmsError(what, FilePlace(str(path)), "choose another -o, or move it away")
