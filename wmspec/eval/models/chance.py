"""The accuracy of guessing: one of the options, or the number of another question of the same kind."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from wmspec.eval.replies import is_near

#: Maximum number of other questions whose numbers are compared with one.
MAX_OTHERS = 500


def chances(questions: Iterable[dict[str, Any]]) -> list[float | None]:
    """Return the probability of guessing each question; None for an open question that is the only one of its kind.

    A question has `task`, `question_name`, `group`, `options` (their number) and, if it is open, `answer_number`,
    `answer_unit` and `answer_within`. The guess of an open question is the number of a random one of the same task and
    name in another control group (in any, if there is no other group).
    """
    listed = list(questions)
    kinds: dict[tuple[str, str], list[tuple[str, float]]] = {}
    for row in listed:
        if not row["options"] and row["answer_number"] is not None:
            kind = (row["task"], row["question_name"] or "")
            kinds.setdefault(kind, []).append((row["group"], float(row["answer_number"])))
    return [1 / row["options"] if row["options"] else _open_chance(row, kinds) for row in listed]


def _open_chance(row: dict[str, Any], kinds: dict[tuple[str, str], list[tuple[str, float]]]) -> float | None:
    known = kinds.get((row["task"], row["question_name"] or ""), [])
    others = [number for group, number in known if group != row["group"]] or [number for _, number in known[1:]]
    if not others or row["answer_number"] is None:
        return None
    others = sorted(others)[:: max(1, len(others) // MAX_OTHERS)]
    unit, within, truth = row["answer_unit"] or "", row["answer_within"] or 0.0, float(row["answer_number"])
    return sum(is_near(number, truth, within, unit) for number in others) / len(others)
