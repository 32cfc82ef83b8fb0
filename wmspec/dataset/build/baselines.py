"""Baseline scores that need no picture, and the number of independent draws behind them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from wmspec.core.parquet_io import read_table
from wmspec.dataset.build.rows import Row


@dataclass(frozen=True)
class Baselines:
    """The number of a task's questions with options, and the accuracies of simple rules.

    `chance` is guessing, `answer` always chooses the most frequent answer, `place` always the most frequent position.
    `groups` is the number of independent control groups.
    """

    questions: int
    groups: int
    chance: float
    answer: float
    place: float


def baselines(files: Iterable[Path]) -> Baselines:
    """Return the baselines of a task from its shard files. Raises OSError if one cannot be read."""
    columns = ["block", "question", "answer", "option_kind", "option_name", "option_text"]
    rows: list[Row] = [row for file in files for row in read_table(file, columns).to_pylist()]
    answered = [row for row in rows if row["answer"] is not None]
    count = max(len(answered), 1)
    return Baselines(
        questions=len(answered),
        groups=len({row["block"] for row in rows}),
        chance=sum(1 / len(row["option_kind"]) for row in answered) / count,
        answer=_most_frequent_hits(answered, "option_name") / count,
        place=_most_frequent_hits(answered, "") / count,
    )


def _most_frequent_hits(rows: Iterable[Row], column: str) -> int:
    """Return the number of questions that the most frequent true value answers.

    Names do not count where options are pictures.
    """
    counted: dict[int, Counter[object]] = {}
    for row in rows:
        named = column and row["option_text"] is not None
        truth = row[column][row["answer"]] if named else row["answer"]
        counted.setdefault(row["question"], Counter())[truth] += 1
    return sum(max(values.values()) for values in counted.values())
