"""Paths of files in reports for code hosts, relative to the root of the repository."""

from __future__ import annotations

import os
from pathlib import Path

from wmspec.lang.parse.files import resolve_display_path


def source_root() -> Path:
    """Return the root of the git repository of the working folder; the working folder if there is none."""
    folder = Path.cwd()
    return next((place for place in (folder, *folder.parents) if (place / ".git").exists()), folder)


def file_of(name: str) -> Path | None:
    """Return the absolute path of a file by its name in messages; None for a text without a file."""
    if name in ("<stdin>", "<text>"):
        return None
    return Path(os.path.abspath(resolve_display_path(name)))  # noqa: PTH100  keeps links, which the repository has


def relative_name(name: str) -> str:
    """Return the path of a file relative to the root of the repository; absolute if it is elsewhere."""
    path = file_of(name)
    if path is None:
        return name
    root = source_root()
    return path.relative_to(root).as_posix() if path.is_relative_to(root) else str(path)
