"""Atomic files, and file-system errors as messages with a remedy."""

from __future__ import annotations

import errno
import fcntl
import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from wmspec.core.diagnostics import WmsError
from wmspec.core.safe_io import make_folders, open_file

#: The subfolder of a dataset with the state of an unfinished run.
PROGRESS = ".progress"
#: The file with the plan of the dataset.
PLAN = "plan.json"
#: The files of a finished dataset in addition to its data; the manifest marks it as complete.
CARD = "README.md"
CROISSANT = "croissant.json"
MANIFEST = "manifest.json"
#: The subfolder with films.
FILMS = "films"
#: The subfolder with an example picture of each task.
EXAMPLES = "examples"

_FULL = "{} cannot be written, {}; free some space or choose another folder with -o, then run the same command again"
_DENIED = "{} cannot be written, {}; choose another folder with -o, or ask for the right to write there"
_IN_THE_WAY = "{} is in the way of a folder or of a file of that name; move it, or choose another folder with -o"
_LONG = "{} is longer than the file system allows; choose a folder with a shorter name with -o"

#: Remedy for each error number of the file system.
REMEDIES = {
    errno.ENOSPC: _FULL,
    errno.EDQUOT: _FULL,
    errno.EFBIG: _FULL,
    errno.EACCES: _DENIED,
    errno.EPERM: _DENIED,
    errno.EROFS: _DENIED,
    errno.EEXIST: _IN_THE_WAY,
    errno.ENOTDIR: _IN_THE_WAY,
    errno.EISDIR: _IN_THE_WAY,
    errno.ENAMETOOLONG: _LONG,
}


@contextmanager
def with_remedies(path: Path) -> Iterator[None]:
    """Turn an error of the file system into a WmsError with a remedy."""
    try:
        yield
    except OSError as error:
        remedy = REMEDIES.get(error.errno or 0, "{} cannot be read or written, {}; choose another folder with -o")
        reason = (error.strerror or str(error)).lower()
        raise WmsError(remedy.format(error.filename or path, reason)) from error


def write(folder: Path, name: str, content: bytes, synced: bool = True) -> None:
    """Write a file atomically: under a temporary name that is then renamed.

    If `synced`, the content reaches the disk before the rename, so that it survives a power cut. Raises WmsError, and
    leaves the previous file, if it cannot be written.
    """
    path, scratch = folder / name, folder / PROGRESS
    part = scratch / f"{hashlib.sha256(name.encode()).hexdigest()[:16]}.part"
    with with_remedies(path):
        make_folders(path.parent)
        try:
            with part.open("wb") as file:
                file.write(content)
                if synced:
                    file.flush()
                    os.fsync(file.fileno())
            part.replace(path)
        except BaseException:
            part.unlink(missing_ok=True)
            raise
        if synced:
            _sync(path.parent)


def _sync(folder: Path) -> None:
    """Flush a new directory entry to the disk."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def pretty_json(value: Any) -> bytes:
    """Return a value as indented JSON with the order of its keys kept; deterministic."""
    return (json.dumps(value, indent=1, ensure_ascii=False) + "\n").encode()


def compact_json(values: dict[str, Any]) -> bytes:
    """Return values as JSON with one key a line, for long lists."""
    entries = (f"{json.dumps(key)}: {json.dumps(value, ensure_ascii=False)}" for key, value in values.items())
    return ("{\n" + ",\n".join(entries) + "\n}\n").encode()


def digest(path: Path) -> str:
    """Return the SHA-256 of a file."""
    with open_file(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def is_intact(path: Path, sha256: str) -> bool:
    """Whether a file is there and has this SHA-256."""
    return path.is_file() and digest(path) == sha256


def lock(path: Path) -> int:
    """Lock a file until the returned descriptor is closed or the process ends.

    Raises WmsError if another process holds the lock.
    """
    with with_remedies(path):
        while True:
            make_folders(path.parent)
            handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                os.close(handle)
                raise WmsError(
                    f"another process is writing to {path.parent.parent}; wait for it, or choose another folder with -o"
                ) from None
            except OSError:
                os.close(handle)
                raise
            if os.fstat(handle).st_nlink:
                return handle
            os.close(handle)  # removed by its last owner in the meantime
