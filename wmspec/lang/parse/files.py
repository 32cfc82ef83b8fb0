"""Locates and reads spec and library files, and formats their paths for messages.

This module imports nothing heavy: a check with a cached result needs no other part of the parser.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from wmspec.core.diagnostics import WmsError
from wmspec.core.limits import XML_BYTES
from wmspec.core.places import FilePlace, Source
from wmspec.core.resources import resource
from wmspec.core.safe_io import is_within, open_file, read_bytes

#: Longer files are rejected: handwritten specs are far shorter.
MAX_CHARACTERS = 1_000_000


def read_source(path: Path) -> Source:
    """Return the text of a file. Raises WmsError if it cannot be read or is a USD stage."""
    try:
        with open_file(path) as file:
            if file.read(8).startswith(_STAGE):
                raise WmsError("it is a USD stage, not a spec", FilePlace(str(path)), _stage_remedy(path))
        text = read_bytes(path, XML_BYTES).decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        raise WmsError(
            f"not UTF-8 text (byte {error.start})", FilePlace(str(path)), "a .wms file is plain UTF-8 text"
        ) from None
    except OSError as error:
        raise WmsError(f"cannot be read: {error.strerror}", FilePlace(str(path))) from None
    if len(text) > MAX_CHARACTERS:
        raise WmsError(
            f"longer than {MAX_CHARACTERS:,} characters",
            FilePlace(str(path)),
            "a spec is written by hand: is this the right file?",
        )
    return Source(display_path(path), text)


#: First bytes of USD files, as text and as binary.
_STAGE = (b"#usda", b"PXR-USDC")


def _stage_remedy(path: Path) -> str:
    """Return the remedy for a stage that was passed as a spec."""
    if path.suffix:
        return f"`wmspec run {path} --for 2s` executes it"
    return f"let its name end in .usd, and `wmspec run {path}.usd --for 2s` executes it"


#: The prefix of the names of bundled libraries.
BUNDLED = "<library>/"


def display_path(path: Path) -> str:
    """Return the path for messages: as given, but bundled libraries as `<library>/tabletop.wms`."""
    if path.parent == library_folder().resolve():
        return f"{BUNDLED}{path.name}"
    return str(path)


def resolve_display_path(name: str) -> Path:
    """Return the path for a name that `display_path` returned."""
    return library_folder() / name.removeprefix(BUNDLED) if name.startswith(BUNDLED) else Path(name)


def library_folder() -> Path:
    """Return the folder of the bundled libraries."""
    return resource("specs/library")


def catalogue_folders() -> tuple[Path, ...]:
    """Return the folders of the catalogue's specs, without those of the gallery and the paradigms."""
    return resource("specs/perception"), resource("specs/prediction")


def search_path() -> tuple[Path, ...]:
    """Return the library folders in WMSPEC_PATH, which has the syntax of PATH."""
    return tuple(Path(folder) for folder in os.environ.get("WMSPEC_PATH", "").split(os.pathsep) if folder)


def find_library(name: str, folder: Path) -> Path | None:
    """Return the file of a library in the folder of its user, on WMSPEC_PATH or among the bundled ones, or None."""
    file = f"{name}.wms"
    if is_within(folder, folder / file):
        return (folder / file).resolve()
    for place in (*search_path(), library_folder()):  # trusted folders: links may lead anywhere
        with suppress(OSError):  # file name too long
            if (path := place / file).is_file():
                return path.resolve()
    return None


def spec_files(paths: Iterable[Path]) -> list[Path]:
    """Return the spec files of the paths; a folder stands for every .wms file below it. Raises WmsError if none."""
    files: list[Path] = []
    for path in paths:
        if path.is_dir():
            below = sorted(spec for spec in path.rglob("*.wms") if is_within(path, spec))
            if not below:
                raise WmsError("there is no .wms file in this folder", FilePlace(str(path)))
            files += below
        else:
            files.append(path)
    return list(dict.fromkeys(files))
