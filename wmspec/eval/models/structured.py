"""Answers constrained by a JSON schema, where a server offers it: a label, or a number."""

from __future__ import annotations

from typing import Any

from wmspec.eval.models.request import Ask


def response_format(ask: Ask) -> dict[str, Any] | None:
    """Return `response_format` of OpenAI's chat completions; None for a question that is answered in words.

    The reply is an object with the key `answer`, which the reader of replies takes as the conclusion.
    """
    question = ask.question
    if ask.labels == "words":
        return None
    labels = [ask.label(place) for place in range(len(question.options))]
    answer: dict[str, Any] = {"type": "string", "enum": labels} if labels else {"type": "number"}
    schema = {
        "type": "object",
        "properties": {"answer": answer},
        "required": ["answer"],
        "additionalProperties": False,
    }
    return {"type": "json_schema", "json_schema": {"name": "answer", "strict": True, "schema": schema}}
