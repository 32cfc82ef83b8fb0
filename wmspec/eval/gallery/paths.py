"""The ways of things through the pictures that a question shows, where the dataset keeps what is seen in each."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from wmspec.core.safe_io import picture
from wmspec.dataset.build.rows import Row

#: The columns that tell it.
IDS, NAMES = "context_ids", "context_names"
#: What has come less far is at rest, in pixels: the middle of what is seen shifts where something covers it.
LEAST = 3.0


def paths(row: Row) -> list[dict[str, object]]:
    """Of everything that moves: its name, and the middle of what is seen of it in each picture (pixels), or null.

    None of a row without ids. Pictures of several cameras have no path in common.
    """
    if not row.get(IDS) or len(set(row["context_camera"])) > 1:
        return []
    seen = [np.asarray(picture(each["bytes"], "PNG")) for each in row[IDS]]
    return list(_moving(seen, row[NAMES]))


def _moving(pictures: list[np.ndarray], names: list[str]) -> Iterator[dict[str, object]]:
    for place, name in enumerate(names, 1):
        middles = [_middle(picture == place) for picture in pictures]
        seen = np.array([middle for middle in middles if middle is not None])
        if len(seen) > 1 and float(np.ptp(seen, axis=0).max()) >= LEAST:
            yield {"name": name, "points": middles}


def _middle(mask: np.ndarray) -> list[float] | None:
    rows, columns = np.nonzero(mask)
    return [round(float(columns.mean()), 1), round(float(rows.mean()), 1)] if len(rows) else None
