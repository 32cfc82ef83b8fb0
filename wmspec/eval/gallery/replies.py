"""Replies of models and people for a gallery, from result files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from wmspec.eval.models import results

#: Maximum length of a displayed reply (characters).
MAX_TEXT_LENGTH = 400


@dataclass(frozen=True)
class GalleryReplies:
    """All replies by question id; `models` are their authors, in order."""

    models: tuple[str, ...]
    by_id: dict[str, list[results.Row]]

    def of(self, id: str) -> list[dict[str, Any]]:
        """Return the replies to a question, in the page's format."""
        return [
            {
                "model": row["model"],
                "parsed": row["parsed"],
                "right": row["right"],
                "status": row["status"],
                "text": row["text"][:MAX_TEXT_LENGTH],
            }
            for row in self.by_id.get(id, ())
        ]


NO_REPLIES = GalleryReplies((), {})


def read(paths: Sequence[Path]) -> GalleryReplies:
    """Read result files, or folders of them. Raises WmsError if one is invalid, or a folder has none."""
    by_id: dict[str, list[results.Row]] = {}
    for path in results.files_of(paths):
        for row in results.read(path)[0]:
            by_id.setdefault(row["id"], []).append(row)
    models = sorted({row["model"] for rows in by_id.values() for row in rows})
    return GalleryReplies(tuple(models), by_id)
