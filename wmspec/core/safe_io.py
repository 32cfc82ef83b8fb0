"""Guarded reads of untrusted names, paths, files and images."""

from __future__ import annotations

import errno
import io
import os
import re
import stat
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from wmspec.core.diagnostics import WmsError
from wmspec.core.limits import FILE_BYTES, FOLDERS, PIXELS, TABLE_BYTES, XML_BYTES, Limit
from wmspec.core.places import FilePlace

if TYPE_CHECKING:  # most specs have no pictures, and checking those should not wait for Pillow
    from PIL import Image

_NAME = re.compile(r"\w[\w.-]{0,99}")


def is_file_name(text: object) -> bool:
    """Whether a text is safe as (part of) a file name: letters, digits and `_`, then also `-` and `.`; at most 100."""
    return isinstance(text, str) and _NAME.fullmatch(text) is not None


@dataclass(frozen=True)
class Searched:
    """The `folders` in which files other than specs were searched, and the paths of these `files`."""

    folders: set[Path] = field(default_factory=set)
    files: set[Path] = field(default_factory=set)


#: The searches for files other than specs, while they are collected.
_searched: ContextVar[Searched | None] = ContextVar("_searched", default=None)


@contextmanager
def files_searched() -> Iterator[Searched]:
    """Collect the files other than specs that the block searches, and their folders."""
    searched, around = Searched(), _searched.get()
    token = _searched.set(searched)
    try:
        yield searched
    finally:
        _searched.reset(token)
        if around is not None:
            around.folders.update(searched.folders)
            around.files.update(searched.files)


def is_within(folder: Path, path: Path) -> bool:
    """Whether a path is a file below the folder after symbolic links are resolved."""
    if (searched := _searched.get()) is not None and path.suffix != ".wms":
        searched.folders.add(folder)
        searched.files.add(path)
    try:
        return path.is_file() and path.resolve().is_relative_to(folder.resolve())
    except (OSError, ValueError, RuntimeError):  # a name that is too long, a null character, links in a circle
        return False


class NotARegularFile(OSError):
    """The path is a pipe or a device: reading it may block or never end."""


def regular_file(path: Path, *, new: bool = False) -> Path:
    """Return the path if it is a regular file, or with `new` if it is free. Raises OSError otherwise."""
    if new and not path.exists():
        return path
    kind = path.stat().st_mode
    if stat.S_ISDIR(kind):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(kind):
        raise NotARegularFile(errno.EINVAL, "it is a pipe or a device, not a file", str(path))
    return path


def make_folders(path: Path) -> Path:
    """Create a folder and its parents. Raises OSError if that is impossible or the path is too deep."""
    if len(path.parts) > FOLDERS.most:
        raise OSError(errno.ENAMETOOLONG, f"it {FOLDERS.sentence}", str(path)[:200] + "...")
    path.mkdir(parents=True, exist_ok=True)
    return path


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Raise WmsError with the reason if the block cannot write to the path."""
    try:
        yield
    except OSError as error:
        raise WmsError(f"cannot be written: {error.strerror or error}", FilePlace(str(path))) from None


def open_file(path: Path) -> io.BufferedReader:
    """Open a regular file; a pipe in its place is not waited for. Raises OSError if it is unreadable or irregular."""
    handle = os.open(regular_file(path), os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise NotARegularFile(errno.EINVAL, "it is a pipe or a device, not a file", str(path))
    return os.fdopen(handle, "rb")


def read_bytes(path: Path, limit: Limit = TABLE_BYTES) -> bytes:
    """Return the bytes of a regular file. Raises OSError if it is unreadable, irregular or above the limit."""
    with open_file(path) as file:
        read = file.read(limit.most + 1)
    if len(read) > limit.most:
        raise OSError(errno.EINVAL, f"it {limit.sentence}", str(path))
    return read


def read_text(path: Path, limit: Limit = XML_BYTES) -> str:
    """Return the text of a UTF-8 file. Raises OSError as `read_bytes` does, and UnicodeDecodeError."""
    return read_bytes(path, limit).decode().replace("\r\n", "\n")


def load_image(source: Path | bytes, *formats: str) -> Image.Image:
    """Decode an image completely. `formats` are Pillow's names, PNG and JPEG by default.

    Raises WmsError if the image has another format, is damaged, or is too large.
    """
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # our own limit is checked below
            content = read_bytes(source, FILE_BYTES) if isinstance(source, Path) else source
            image = Image.open(io.BytesIO(content), "r", formats or _FORMATS)
            if image.width * image.height > PIXELS.most:
                raise PIXELS.exceeded()
            image.load()
    except Image.DecompressionBombError:
        raise PIXELS.exceeded() from None
    except (OSError, SyntaxError, ValueError, EOFError, MemoryError, AttributeError, IndexError, KeyError) as error:
        kinds = " or ".join(formats or _FORMATS)
        reason = error.strerror if isinstance(error, OSError) and error.strerror else f"it is damaged, or no {kinds}"
        raise WmsError(f"cannot be read: {reason}", help="save it again") from None
    return image


_FORMATS = ("PNG", "JPEG")
