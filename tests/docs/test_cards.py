"""Every task of the catalogue has a card with a question, and its answer."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator

from tools.cards import ANSWERS, PICTURES
from wmspec.lang.parse.files import catalogue_folders


def names() -> Iterator[str]:
    """The names of all tasks and of their variants, as the specs declare them."""
    for path in (path for folder in catalogue_folders() for path in sorted(folder.rglob("*.wms"))):
        _, *parts = re.split(r"^task (\w+)", path.read_text(), flags=re.MULTILINE)
        for task, body in zip(parts[::2], parts[1::2], strict=True):
            variants = re.findall(r"^  variant (\w+)", body, re.MULTILINE)
            yield from (f"{task}_{variant}" for variant in variants) if variants else (task,)


def test_every_task_has_a_card_with_an_answer() -> None:
    tasks = sorted(names())
    assert len(tasks) == 54
    assert sorted(json.loads(ANSWERS.read_text())) == tasks
    assert sorted(path.stem for path in PICTURES.glob("*.webp")) == tasks
