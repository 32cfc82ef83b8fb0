"""What models and people answered, beside the truth: from files of results."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from wmspec.core.diagnostics import WmsError
from wmspec.eval.models import results

#: How much of a reply's text is shown, in characters.
LONGEST = 400


@dataclass(frozen=True)
class Replies:
    """All replies by the question's id; `models` are who gave them, in order."""

    models: tuple[str, ...]
    by_id: dict[str, list[results.Row]]

    def of(self, id: str) -> list[dict[str, Any]]:
        """The replies to a question, as the page takes them."""
        return [
            {
                "model": row["model"],
                "parsed": row["parsed"],
                "right": row["right"],
                "status": row["status"],
                "text": row["text"][:LONGEST],
            }
            for row in self.by_id.get(id, ())
        ]


NONE = Replies((), {})


def read(paths: Sequence[Path]) -> Replies:
    """Read files of results, or folders of them. Raises WmsError if one holds none, or a folder has no file."""
    by_id: dict[str, list[results.Row]] = {}
    for path in _files(paths):
        for row in results.read(path)[0]:
            by_id.setdefault(row["id"], []).append(row)
    models = sorted({row["model"] for rows in by_id.values() for row in rows})
    return Replies(tuple(models), by_id)


def _files(paths: Sequence[Path]) -> list[Path]:
    files: list[Path] = []
    for path in paths:
        below = sorted(path.rglob("*.parquet")) if path.is_dir() else [path]
        if not below:
            raise WmsError(f"{path} holds no results; `wmspec evaluate` writes them as .parquet files")
        files += below
    return list(dict.fromkeys(files))
