"""A cache in the user's folder: small files, each complete or absent, of results that can be computed again.

The folder is `$WMSPEC_CACHE_DIR`, else `$XDG_CACHE_HOME/wmspec`, else `~/.cache/wmspec`. After any error
(no permission, a full disk, a damaged file), the cache behaves as if the entry were absent.

Trust: the folder and each entry must belong to the user who runs wmspec and be writable by nobody else; otherwise they
are ignored. Whoever can write there as that user can change wmspec itself. A checksum in front of each
entry finds accidental damage. Entries hold data only: JSON, or pickles of nodes (`node_pickle`), so that even a forged
entry cannot execute code.
"""

from __future__ import annotations

import hashlib
import os
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

import wmspec

#: With more entries than this, the older half is removed.
MAX_ENTRIES = 4000
#: Number of entries that one object writes between two searches for old ones.
_PRUNING_INTERVAL = 200
_CHECKSUM = hashlib.sha256().digest_size
_WRITABLE_BY_OTHERS = stat.S_IWGRP | stat.S_IWOTH

_disabled = False


@contextmanager
def disabled() -> Iterator[None]:
    """Neither read nor write entries within the block."""
    global _disabled  # noqa: PLW0603  one user per process
    before, _disabled = _disabled, True
    try:
        yield
    finally:
        _disabled = before


def folder() -> Path:
    """Return the cache folder."""
    if named := os.environ.get("WMSPEC_CACHE_DIR"):
        return Path(named)
    return Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "wmspec")  # noqa: PTH111  need not be


def read(name: str) -> bytes | None:
    """Return the content of an entry in the user's folder; None if there is none or it is not trusted."""
    return DiskCache(folder()).read(name)


def write(name: str, content: bytes) -> None:
    """Make an entry in the user's folder."""
    DiskCache(folder()).write(name, content)


class DiskCache:
    """Entries in one folder, at most `most` of them. `refused` counts the entries that were not trusted."""

    def __init__(self, place: Path, most: int | None = None) -> None:
        self.place = place
        self.refused = self._written = 0
        self._most = MAX_ENTRIES if most is None else most

    def read(self, name: str) -> bytes | None:
        """Return the content of an entry; None if there is none or it is not trusted."""
        if _disabled:
            return None
        with suppress(OSError):
            handle = os.open(self.place / name, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
            with os.fdopen(handle, "rb") as file:
                status = os.fstat(handle)
                if stat.S_ISREG(status.st_mode) and _ours(status) and _ours(self.place.stat()):
                    checksum, content = file.read(_CHECKSUM), file.read()
                    if checksum == hashlib.sha256(content).digest():
                        return content
            self.refused += 1
        return None

    def write(self, name: str, content: bytes) -> None:
        """Make an entry, whole or not at all: another process may read it at any time."""
        if _disabled:
            return
        import tempfile

        with suppress(OSError):
            self.place.mkdir(parents=True, exist_ok=True, mode=0o700)
            if not _ours(self.place.stat()):
                return
            handle, temporary = tempfile.mkstemp(dir=self.place, suffix=".part")
            try:
                with os.fdopen(handle, "wb") as file:
                    file.write(hashlib.sha256(content).digest() + content)
                Path(temporary).replace(self.place / name)
            except OSError:
                Path(temporary).unlink(missing_ok=True)
                raise
            if self._written % _PRUNING_INTERVAL == 0:
                _prune(self.place, self._most)
            self._written += 1


def _ours(status: os.stat_result) -> bool:
    return status.st_uid == os.geteuid() and not status.st_mode & _WRITABLE_BY_OTHERS


def _prune(place: Path, most: int) -> None:
    names = os.listdir(place)  # noqa: PTH208  names are enough
    if len(names) > most:
        written = []
        for name in names:
            with suppress(OSError):  # another process was quicker
                written.append(((place / name).stat().st_mtime_ns, name))
        for _, name in sorted(written)[: len(written) // 2]:
            with suppress(OSError):
                (place / name).unlink(missing_ok=True)


# ---------------------------------------------------------------- what entries depend on


@cache
def fingerprint() -> str:
    """A digest of wmspec's version and files, of Python, and of the packages that are installed.

    Files count by size and time of change, as for Python's own bytecode; packages by the time at which their folders
    last changed. Reading them all would take longer than a check.
    """
    facts: list[object] = [wmspec.__version__, sys.version]
    root = Path(wmspec.__file__).parent
    folders = [root, *(Path(more, name) for more in wmspec.__path__[1:] for name in ("grammar", "specs/library"))]
    for each in folders:
        facts += sorted(_files(str(each)))
    for entry in sys.path:
        if entry.endswith("-packages"):
            with suppress(OSError):
                facts.append((os.path.realpath(entry), os.stat(entry).st_mtime_ns))  # noqa: PTH116
    return digest(repr(facts).encode())


def _files(folder: str) -> Iterator[tuple[str, int, int]]:
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if entry.is_dir():
                if entry.name != "__pycache__":
                    yield from _files(entry.path)
            else:
                status = entry.stat()
                yield entry.path, status.st_size, status.st_mtime_ns


def digest(content: bytes) -> str:
    """The SHA-256 of some bytes, as text."""
    return hashlib.sha256(content).hexdigest()
