"""The specs in a manifest: their hashes, and whether they are those that wmspec ships."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator

from wmspec import __version__
from wmspec.core.safe_io import read_bytes
from wmspec.dataset.build.files import MANIFEST
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.verify.model import Difference
from wmspec.lang.parse.files import BUNDLED, library_folder


def spec_differences(dataset: DatasetReader) -> Iterator[Difference]:
    """Yield the specs whose text does not match its hash, and bundled libraries that wmspec ships in another form."""
    same_version = dataset.manifest["versions"].get("wmspec") == __version__
    for name, spec in dataset.manifest["specs"].items():
        if hashlib.sha256(spec["text"].encode()).hexdigest() != spec["sha256"]:
            yield Difference(MANIFEST, f"specs.{name}", "the text does not match its hash")
        if name.startswith(BUNDLED) and same_version and spec["text"] != _bundled(name):
            yield Difference(MANIFEST, f"specs.{name}", f"the text is not that of wmspec {__version__}")


def _bundled(name: str) -> str | None:
    """Return the text of a bundled library, or None if there is none of that name."""
    file = name.removeprefix(BUNDLED)
    if "/" in file:
        return None
    try:
        return read_bytes(library_folder() / file).decode().replace("\r\n", "\n")
    except OSError:
        return None
