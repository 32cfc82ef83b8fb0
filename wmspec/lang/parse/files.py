"""The files of specs and libraries: where they are looked for, how they are read, and what messages call them.

Nothing here is heavy to import: a check whose result is cached needs no more of the parser than this.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from wmspec.core.diagnostics import WmsError
from wmspec.core.limits import MARKUP
from wmspec.core.places import FilePlace, Source
from wmspec.core.resources import resource
from wmspec.core.safe_io import inside, plain, read_plain

#: A longer file is refused: no hand writes it.
MAX_CHARACTERS = 1_000_000


def read_source(path: Path) -> Source:
    """The text of a file. Raises WmsError with the reason if it cannot be read, or is a USD stage."""
    try:
        with plain(path).open("rb") as file:
            if file.read(8).startswith(_STAGE):
                raise WmsError("it is a USD stage, not a spec", FilePlace(str(path)), _run(path))
        text = read_plain(path, MARKUP).decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
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
    return Source(shown(path), text)


#: How USD's own files begin, as text and as binary.
_STAGE = (b"#usda", b"PXR-USDC")


def _run(path: Path) -> str:
    """What to do with a stage."""
    if path.suffix:
        return f"`wmspec run {path} --for 2s` executes it"
    return f"let its name end in .usd, and `wmspec run {path}.usd --for 2s` executes it"


def shown(path: Path) -> str:
    """How a path is told: as it was given, but the libraries that come with wmspec as `<library>/tabletop.wms`."""
    if path.parent == library_folder().resolve():
        return f"<library>/{path.name}"
    return str(path)


def located(name: str) -> Path:
    """The file that was told as `name`."""
    return library_folder() / name.removeprefix("<library>/") if name.startswith("<library>/") else Path(name)


def library_folder() -> Path:
    """The folder of the libraries that come with wmspec."""
    return resource("specs/library")


def catalogue_folders() -> tuple[Path, ...]:
    """The folders of the specs that rebuild the paper's tasks; those of the gallery are apart."""
    return resource("specs/perception"), resource("specs/prediction")


def search_path() -> tuple[Path, ...]:
    """The folders in WMSPEC_PATH, in which libraries are looked for too, parted as in PATH."""
    return tuple(Path(folder) for folder in os.environ.get("WMSPEC_PATH", "").split(os.pathsep) if folder)


def found(name: str, folder: Path) -> Path | None:
    """The file of a library: in the folder of the file that uses it, on WMSPEC_PATH, or wmspec's own."""
    file = f"{name}.wms"
    if inside(folder, folder / file):
        return (folder / file).resolve()
    for place in (*search_path(), library_folder()):  # which the user or wmspec chose: links may lead anywhere
        with suppress(OSError):  # a name longer than file names can be
            if (path := place / file).is_file():
                return path.resolve()
    return None


def spec_files(paths: Iterable[Path]) -> list[Path]:
    """The spec files meant: a file as it is, a folder as every .wms below it. Raises WmsError where there is none."""
    files: list[Path] = []
    for path in paths:
        if path.is_dir():
            below = sorted(spec for spec in path.rglob("*.wms") if inside(path, spec))
            if not below:
                raise WmsError("there is no .wms file in this folder", FilePlace(str(path)))
            files += below
        else:
            files.append(path)
    return list(dict.fromkeys(files))
