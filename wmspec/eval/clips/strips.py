"""Film strips: of each task the clip with the median error and the worst one, each above its true future."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from wmspec.dataset.build import typeset
from wmspec.dataset.build.rows import Row
from wmspec.dataset.film.codec import Frames

#: Number of frames of a strip, and their width (px).
FRAMES, WIDTH = 6, 176
_CAPTION, _GAP = 13, 6


def representative(rows: Iterable[Row]) -> list[tuple[str, Row]]:
    """Return the row with the median and the row with the largest final error of each task, each with its name."""
    tasks: dict[str, list[Row]] = {}
    for row in rows:
        if row["final_error"] is not None:
            tasks.setdefault(row["task"], []).append(row)
    chosen = []
    for of_task in tasks.values():
        ordered = sorted(of_task, key=lambda row: (row["final_error"], row["id"], row["sample"]))
        chosen += [("median", ordered[(len(ordered) - 1) // 2]), ("worst", ordered[-1])]
    return chosen


def caption(which: str, row: Row) -> str:
    """Return the caption of a strip."""
    outcome = "right" if row["right"] else "another future" if row["why"] == [] else f"none: {', '.join(row['why'])}"
    return f"{row['id']}, {which}: {outcome}; ends {row['final_error']:.2f} widths from the truth"


def sheet(strips: Sequence[tuple[str, Frames, Frames]]) -> Image.Image:
    """Return one picture of strips: the caption, the frames of a clip (n, h, w, 3), and below them the true future."""
    style, width = typeset.Style(_CAPTION), FRAMES * (WIDTH + _GAP)
    parts = []
    for words, *films in strips:
        parts.append(typeset.paragraph(words, style, width))
        parts += [typeset.hstack([_shrunk(frame) for frame in _spread(film)], _GAP) for film in films]
    return typeset.pad(typeset.vstack(parts, _GAP), 2 * _GAP)


def _spread(frames: Frames) -> Frames:
    return np.asarray(frames[np.linspace(0, len(frames) - 1, FRAMES).round().astype(int)], np.uint8)


def _shrunk(frame: NDArray[np.uint8]) -> Image.Image:
    picture = Image.fromarray(frame)
    return picture.resize((WIDTH, round(WIDTH * picture.height / picture.width)), Image.Resampling.BOX)
