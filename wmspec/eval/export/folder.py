"""A folder being exported."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from wmspec.core.diagnostics import WmsError
from wmspec.core.resources import resource
from wmspec.core.safe_io import make_folders, read_bytes
from wmspec.dataset.build import files
from wmspec.dataset.build.reader import DatasetReader

#: The file that marks a folder as an export, with its settings and files.
MARK_FILE = "export.json"


@dataclass
class Folder:
    """A folder being written, and the files written to it."""

    place: Path
    written: list[str] = field(default_factory=list)

    def path(self, name: str) -> Path:
        """Return the path for a file of this name, and record it."""
        self.written.append(name)
        path = self.place / name
        make_folders(path.parent)
        return path

    def copy(self, name: str, to: str, **words: str) -> None:
        """Copy a packaged file, with words in braces replaced."""
        text = resource(name).read_text(encoding="utf-8")
        for word, value in words.items():
            text = text.replace(f"{{{word}}}", value)
        self.path(to).write_text(text, encoding="utf-8")

    def copy_reader(self) -> None:
        """Copy the reader of replies, which runs without wmspec."""
        for module in sorted(resource("eval/replies").glob("*.py")):
            self.copy(f"eval/replies/{module.name}", f"wmspec_reply/{module.name}")

    def table(self, name: str, lines: Sequence[dict[str, Any]]) -> None:
        """Write lines, of which there is one at least, as CSV."""
        with self.path(name).open("w", newline="", encoding="utf-8") as file:
            out = csv.DictWriter(file, list(lines[0]), lineterminator="\n")
            out.writeheader()
            out.writerows(lines)

    def mark(self, dataset: DatasetReader, to: str, **about: object) -> None:
        """Write the file that marks the folder as an export, with its settings and files."""
        digest = files.digest(dataset.folder / files.MANIFEST)
        known: dict[str, object] = {"to": to, "dataset": digest, **about, "files": sorted(self.written)}
        (self.place / MARK_FILE).write_bytes(files.pretty_json(known))

    def clear(self) -> None:
        """Remove the files of an earlier export. Raises WmsError if the folder holds anything else."""
        if not self.place.exists() or not any(self.place.iterdir()):
            return
        try:
            before = json.loads(read_bytes(self.place / MARK_FILE))["files"]
        except (OSError, ValueError, LookupError, TypeError, RecursionError):
            raise WmsError(f"{self.place} holds files that are not an export; choose another folder with -o") from None
        inside = self.place.resolve()
        for path in [(self.place / str(name)).resolve() for name in before]:
            if path.is_relative_to(inside):
                path.unlink(missing_ok=True)
