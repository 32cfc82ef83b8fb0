"""Causes for which questions have no answer, in groups with one example each."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from wmspec.eval.replies import Outcome

#: Outcomes without an answer, in the order in which they are printed, and remedies.
LOST: tuple[Outcome, ...] = ("error", "refused", "truncated", "unparsed")
REMEDIES: dict[str, str] = {
    "error": "the same command sends them again",
    "truncated": "raise the limit of tokens, such as -p max_tokens=8192, with another -o",
}
#: The beginning of the text of a clip that shows no future, before the reasons.
NO_FUTURE = "none of the futures"
#: Maximum length of an example (characters).
MAX_EXAMPLE_LENGTH = 160


@dataclass(frozen=True)
class Cause:
    """A cause of `count` replies without an answer; `id` is a question with it, `example` the message or reply."""

    outcome: Outcome
    cause: str
    count: int
    id: str
    example: str

    def __str__(self) -> str:
        remedy = f"; {REMEDIES[self.outcome]}" if self.outcome in REMEDIES else ""
        example = f": {self.example}" if self.example else ""
        return f"{self.count:,} {self.outcome}, {self.cause} (such as {self.id}){example}{remedy}"


def causes(rows: Iterable[dict[str, Any]]) -> tuple[Cause, ...]:
    """Return the causes of rows of results, the most frequent first.

    A row has `status`, `id`, `text`, `error` and `finish_reason`.
    """
    groups: dict[tuple[Outcome, str], list[dict[str, Any]]] = {}
    for row in rows:
        if row["status"] in LOST:
            groups.setdefault((row["status"], _cause(row)), []).append(row)
    found = [_group(outcome, cause, those) for (outcome, cause), those in groups.items()]
    return tuple(sorted(found, key=lambda c: (LOST.index(c.outcome), -c.count, c.cause)))


def _group(outcome: Outcome, cause: str, rows: list[dict[str, Any]]) -> Cause:
    """Return a cause with the first example by id, which does not depend on the order of the rows."""
    first = min(rows, key=lambda row: (row["id"], row["text"] or "", row["error"] or ""))
    return Cause(outcome, cause, len(rows), first["id"], _example(first).rstrip("."))


def _cause(row: dict[str, Any]) -> str:
    """Return the group of a row: its error without the parts that differ between requests."""
    if row["status"] == "error":
        return _generic(row["error"] or "no reply")
    if row["status"] == "refused":
        return f"withheld by a filter ({row['finish_reason']})" if row["finish_reason"] else "withheld by a filter"
    if row["status"] == "truncated":
        return "cut off by the limit of tokens"
    text = (row["text"] or "").strip()
    if text.startswith(NO_FUTURE):
        return text
    return "no option or number can be read" if text else "the reply is empty"


def _generic(message: str) -> str:
    head = re.split(r"[{\n]|\s\(|(?<=\d) - ", message, maxsplit=1)[0]
    head = re.sub(r"\b[0-9a-f]{8,}\b|\b(?:req|chatcmpl|call)[-_]\w+", "…", head)
    return re.sub(r"\d+(?:[.,]\d+)+|\b\d{5,}\b", "#", head).strip(" -:.")[:120] or "no reply"


def _example(row: dict[str, Any]) -> str:
    shown = row["text"] if row["status"] in {"unparsed", "truncated"} else row["error"]
    text = " ".join((shown or "").split())
    if text == _cause(row):
        return ""
    if row["status"] == "truncated":
        return text if len(text) <= MAX_EXAMPLE_LENGTH else "… " + text[-MAX_EXAMPLE_LENGTH:]
    return text if len(text) <= MAX_EXAMPLE_LENGTH else text[:MAX_EXAMPLE_LENGTH] + " …"
