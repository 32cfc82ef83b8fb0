"""The outcome and score of a reply."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from .choice import choice
from .numbers import is_near, number_in

#: What became of a question: an answer that was read, one that was not, one that was cut off, one that a filter
#: withheld, or none. Only `answered` can be right.
Outcome = Literal["answered", "unparsed", "truncated", "refused", "error"]

#: Reasons for which servers end a reply, by their names: the limit of tokens, and a filter.
FINISHED_BY_LENGTH = frozenset({"length", "max_tokens", "model_length", "max_output_tokens", "MAX_TOKENS"})
FINISHED_BY_FILTER = frozenset({"content_filter", "safety", "SAFETY", "refusal", "RECITATION", "PROHIBITED_CONTENT"})

#: Status codes of requests that a filter stops, and words of its messages.
_FILTER_STATUS = frozenset({400, 403, 422, 451})
_FILTERED = re.compile(
    r"(?i)content[_ -]?(?:filter|policy|management)|responsible[ _]?ai|safety (?:system|filter|polic)|moderation"
    r"|flagged|prohibited[_ ]content|sensitive content|data_inspection_failed"
)


@dataclass(frozen=True)
class Mark:
    """A scored reply: outcome, the chosen position (as shown) or number, None without one, and whether it is right."""

    outcome: Outcome
    place: int | None
    number: float | None
    right: bool

    @property
    def parsed(self) -> bool:
        """Whether an answer was read."""
        return self.outcome == "answered"


def is_withheld(status: int | None, message: str) -> bool:
    """Whether an error of a server, with its HTTP status and message, says that a filter withheld the reply."""
    return status in _FILTER_STATUS and _FILTERED.search(message) is not None


def mark(
    text: str,
    options: Sequence[str | None],
    labels: str = "letters",
    answer: int | None = None,
    number: float | None = None,
    unit: str | None = None,
    within: float | None = None,
    finish: str | None = None,
) -> Mark:
    """Read and score a reply.

    `options` are the words of each option as shown, None for a picture; `answer` is the position of the true one as
    shown. Without options the question is open, and a number `within` of `number` (SI `unit`) is right. `finish` is the
    reason for which the server ended the reply: `refused` if a filter did; `truncated` if the limit of tokens did,
    unless the reply begins with an option.
    """
    if finish in FINISHED_BY_FILTER:
        return Mark("refused", None, None, False)
    cut = finish in FINISHED_BY_LENGTH
    if options:
        place = choice(text, options, labels, whole=not cut)
        outcome: Outcome = "answered" if place is not None else "truncated" if cut else "unparsed"
        return Mark(outcome, place, None, place is not None and place == answer)
    value = None if cut else number_in(text, unit or "")
    if value is None:
        return Mark("truncated" if cut else "unparsed", None, None, False)
    return Mark("answered", None, value, number is not None and is_near(value, number, within or 0.0, unit or ""))


def mark_row(text: str, row: Mapping[str, Any], finish: str | None = None) -> Mark:
    """Read and score a reply to the question of a row: its `options`, `labels`, `answer`, `answer_number` and so on."""
    number = {name: row[f"answer_{name}"] for name in ("number", "unit", "within")}
    return mark(text, row["options"], row["labels"], row["answer"], **number, finish=finish)
