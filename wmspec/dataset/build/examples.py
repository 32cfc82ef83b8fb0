"""Example pictures: one question of each task, for the card."""

from __future__ import annotations

import io
from collections.abc import Iterator

from PIL import Image

from wmspec.dataset.build.card import example
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.build.sheet import question_of

#: The width of an example (px), and its WebP quality.
WIDTH, QUALITY = 1000, 80


def examples(dataset: DatasetReader) -> Iterator[tuple[str, bytes]]:
    """Yield the path and content of the example of every task that has questions.

    Raises WmsError if a shard cannot be read.
    """
    for task in dataset.tasks:
        shown = question_of(dataset, task)
        if shown is not None:
            out = io.BytesIO()
            small = shown.resize((WIDTH, round(shown.height * WIDTH / shown.width)), Image.Resampling.LANCZOS)
            small.save(out, "WEBP", quality=QUALITY, method=4)
            yield example(task), out.getvalue()
