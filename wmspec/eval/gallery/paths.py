"""Paths of objects through the pictures of a question, where the dataset has segmentation ids."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from wmspec.core.safe_io import load_image
from wmspec.dataset.build.rows import Row

#: The columns with segmentation ids and names.
IDS, NAMES = "context_ids", "context_names"
#: Minimum motion of an object (px); the visible centre also shifts under occlusion.
MIN_MOTION = 3.0


def paths(row: Row) -> list[dict[str, object]]:
    """Return the name of each moving object, and the centre of its visible part in each picture (px), or null.

    Empty for a row without ids, or with pictures of several cameras.
    """
    if not row.get(IDS) or len(set(row["context_camera"])) > 1:
        return []
    seen = [np.asarray(load_image(each["bytes"], "PNG")) for each in row[IDS]]
    return list(_moving_paths(seen, row[NAMES]))


def _moving_paths(pictures: list[np.ndarray], names: list[str]) -> Iterator[dict[str, object]]:
    for place, name in enumerate(names, 1):
        middles = [_centre(image == place) for image in pictures]
        seen = np.array([middle for middle in middles if middle is not None])
        if len(seen) > 1 and float(np.ptp(seen, axis=0).max()) >= MIN_MOTION:
            yield {"name": name, "points": middles}


def _centre(mask: np.ndarray) -> list[float] | None:
    rows, columns = np.nonzero(mask)
    return [round(float(columns.mean()), 1), round(float(rows.mean()), 1)] if len(rows) else None
