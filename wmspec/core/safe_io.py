"""What others wrote, checked before it is used: a name as a name, a path as one that stays, a picture as a picture."""

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
from pathlib import Path
from typing import TYPE_CHECKING

from wmspec.core.diagnostics import WmsError
from wmspec.core.limits import FOLDERS, PIXELS, RECORDS, Limit

if TYPE_CHECKING:  # most specs have no pictures, and checking those should not wait for Pillow
    from PIL import Image

_NAME = re.compile(r"\w[\w.-]{0,99}")


def is_name(text: object) -> bool:
    """Whether a text can be (part of) the name of a file: letters, digits, `_`, and later also `-` and `.`."""
    return isinstance(text, str) and _NAME.fullmatch(text) is not None


#: While files that a spec names are being collected: the folders in which any were looked for, libraries apart.
_searched: ContextVar[set[Path] | None] = ContextVar("_searched", default=None)


@contextmanager
def folders_searched() -> Iterator[set[Path]]:
    """Collects the folders in which the block looks for files other than specs."""
    folders = set[Path]()
    token = _searched.set(folders)
    try:
        yield folders
    finally:
        _searched.reset(token)


def inside(folder: Path, path: Path) -> bool:
    """Whether there is a file at a path that lies below the folder, wherever symbolic links lead."""
    if (searched := _searched.get()) is not None and path.suffix != ".wms":
        searched.add(folder)
    try:
        return path.is_file() and path.resolve().is_relative_to(folder.resolve())
    except (OSError, ValueError, RuntimeError):  # a name that is too long, a null character, links in a circle
        return False


class Endless(OSError):
    """What is to be read is no file: a pipe waits for whoever writes to it, a device may go on for ever."""


def plain(path: Path) -> Path:
    """The path of a file that has an end: pipes and devices may have none. Raises OSError if there is no such file."""
    kind = path.stat().st_mode
    if stat.S_ISDIR(kind):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(kind):
        raise Endless(errno.EINVAL, "it is a pipe or a device, not a file", str(path))
    return path


def make_folders(path: Path) -> Path:
    """Create a folder and those above it. Raises OSError if that is impossible, or if it lies too deep."""
    if len(path.parts) > FOLDERS.most:
        raise OSError(errno.ENAMETOOLONG, f"it {FOLDERS.sentence}", str(path)[:200] + "...")
    path.mkdir(parents=True, exist_ok=True)
    return path


def read_plain(path: Path, limit: Limit = RECORDS) -> bytes:
    """All of a file. Raises OSError if it cannot be read, is no plain file, or is larger than that."""
    with plain(path).open("rb") as file:
        read = file.read(limit.most + 1)
    if len(read) > limit.most:
        raise OSError(errno.EINVAL, f"it {limit.sentence}", str(path))
    return read


def picture(source: Path | bytes, *formats: str) -> Image.Image:
    """A picture, read to its end: of one of Pillow's `formats`, PNG or JPEG if none are named.

    Raises WmsError if it is something else, damaged, or too large.
    """
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # our own limit is told below
            image = Image.open(source if isinstance(source, Path) else io.BytesIO(source), "r", formats or _FORMATS)
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
