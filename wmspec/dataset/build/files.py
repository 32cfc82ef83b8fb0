"""Files that are there whole or not at all, and what can go wrong with a disk said in a sentence with its remedy."""

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
from wmspec.core.safe_io import make_folders

#: Where a dataset's folder keeps what its maker needs to go on.
PROGRESS = ".progress"
#: Its file that says what the folder is to hold.
PLAN = "plan.json"
#: The files that a finished dataset has beside its data; the last says that it is whole.
CARD = "README.md"
CROISSANT = "croissant.json"
MANIFEST = "manifest.json"
#: The folder of its pictures for people: an example of each task.
EXAMPLES = "examples"

_FULL = "{} cannot be written, {}; free some space or choose another folder with -o, then run the same command again"
_DENIED = "{} cannot be written, {}; choose another folder with -o, or ask for the right to write there"
_IN_THE_WAY = "{} is in the way of a folder or of a file of that name; move it, or choose another folder with -o"
_LONG = "{} is longer than the file system allows; choose a folder with a shorter name with -o"

#: What the user can do about an error of the file system.
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
def explained(path: Path) -> Iterator[None]:
    """Turn an error of the file system into a WmsError with a remedy."""
    try:
        yield
    except OSError as error:
        remedy = REMEDIES.get(error.errno or 0, "{} cannot be read or written, {}; choose another folder with -o")
        reason = (error.strerror or str(error)).lower()
        raise WmsError(remedy.format(error.filename or path, reason)) from error


def write(folder: Path, name: str, content: bytes, synced: bool = True) -> None:
    """Write a folder's file `name` whole or not at all: under another name, and only then under its own.

    If `synced`, it is on the disk before it has its name, so that a power cut leaves it whole too. Raises WmsError, and
    leaves what was there before, if it cannot be written.
    """
    path, scratch = folder / name, folder / PROGRESS
    part = scratch / f"{hashlib.sha256(name.encode()).hexdigest()[:16]}.part"
    with explained(path):
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
    """Make the folder's new entry last through a power cut."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def text(value: Any) -> bytes:
    """A value as JSON for people: indented, in the order of its keys, the same bytes for the same value."""
    return (json.dumps(value, indent=1, ensure_ascii=False) + "\n").encode()


def lines(values: dict[str, Any]) -> bytes:
    """Values as JSON with one key a line: for lists that are too long to be read."""
    entries = (f"{json.dumps(key)}: {json.dumps(value, ensure_ascii=False)}" for key, value in values.items())
    return ("{\n" + ",\n".join(entries) + "\n}\n").encode()


def digest(path: Path) -> str:
    """The SHA-256 of a file's content."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def lock(path: Path) -> int:
    """Hold the lock of a file until the returned descriptor is closed or the process ends, however that happens.

    Raises WmsError if another process holds it.
    """
    with explained(path):
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
            os.close(handle)  # whoever held it has just removed it
