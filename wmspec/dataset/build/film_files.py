"""The film files of a dataset folder."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from pathlib import Path

from wmspec.dataset.build import files

#: The path of a film, which contains the name of its task.
FILM = re.compile(r"films/(\w[\w.-]{0,99})/\d{1,18}_\w{1,40}/\d{1,18}(?:\.ids)?\.mkv")


def damaged_film(folder: Path, films: Mapping[str, str]) -> str:
    """Return the first film that is missing or does not have its SHA-256, or ''."""
    return next((path for path, sha in films.items() if not files.is_intact(folder / path, sha)), "")


def unlisted_films(folder: Path, known: Collection[str]) -> list[str]:
    """Return the films in a folder that are not in `known`, in order."""
    there = (path.relative_to(folder).as_posix() for path in sorted((folder / files.FILMS).glob("*/*/*.mkv")))
    return [path for path in there if path not in known]


def clear_films(folder: Path) -> None:
    """Remove the films of a dataset, and the folders that are then empty."""
    for path in unlisted_films(folder, ()):
        if FILM.fullmatch(path):
            (folder / path).unlink()
    for place in sorted((folder / files.FILMS).glob("**/"), reverse=True):
        if not any(place.iterdir()):
            place.rmdir()
