"""What is right without looking: the scores that a model has to be better than, and from how many draws they come."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import pyarrow.parquet as pq

from wmspec.dataset.build.rows import Row


@dataclass(frozen=True)
class Baselines:
    """Of a task's questions with options: how many there are, and the shares that are right by simple rules.

    By `chance`, by always taking the commonest `answer`, and by always taking the commonest `place`. `groups` are its
    independent control groups.
    """

    asked: int
    groups: int
    chance: float
    answer: float
    place: float


def baselines(files: Iterable[Path]) -> Baselines:
    """The baselines of the task whose shards these are. Raises OSError if one cannot be read."""
    columns = ["block", "question", "answer", "option_kind", "option_name", "option_text"]
    rows: list[Row] = [row for file in files for row in pq.read_table(file, columns=columns).to_pylist()]
    asked = [row for row in rows if row["answer"] is not None]
    count = max(len(asked), 1)
    return Baselines(
        asked=len(asked),
        groups=len({row["block"] for row in rows}),
        chance=sum(1 / len(row["option_kind"]) for row in asked) / count,
        answer=_commonest(asked, "option_name") / count,
        place=_commonest(asked, "") / count,
    )


def _commonest(rows: Iterable[Row], column: str) -> int:
    """How many are right if the commonest truth is always said; names tell nothing where options are pictures."""
    counted: dict[int, Counter[object]] = {}
    for row in rows:
        named = column and row["option_text"] is not None
        truth = row[column][row["answer"]] if named else row["answer"]
        counted.setdefault(row["question"], Counter())[truth] += 1
    return sum(max(values.values()) for values in counted.values())
