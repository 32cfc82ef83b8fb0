"""Chat completions: parameters, which a server may reject, the schema of an answer, and what a response says."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from typing import Any

from wmspec.eval.models.model import Reply, storable
from wmspec.eval.models.request import Ask

#: The limit of tokens by its two names, and its default where a server wants the second, as reasoning models do.
OLD_LIMIT, NEW_LIMIT, REASONING_LIMIT = "max_tokens", "max_completion_tokens", 16_384
#: Words of a message that rejects a parameter.
_REJECTIONS = (
    "unsupported",
    "not supported",
    "does not support",
    "unrecognized",
    "deprecated",
    "not compatible",
    "only the default",
)


class Parameters:
    """The parameters of requests, adapted to a server. Only those in `defaults`, which no user chose, are left out."""

    def __init__(self, values: dict[str, Any], defaults: frozenset[str]) -> None:
        self._values, self._defaults = dict(values), defaults
        self._notes: list[str] = []
        self._turn = threading.Lock()

    @property
    def values(self) -> dict[str, Any]:
        """The parameters that are sent now."""
        with self._turn:
            return dict(self._values)

    @property
    def notes(self) -> tuple[str, ...]:
        """What was changed, in sentences."""
        return tuple(self._notes)

    def learn(self, sent: dict[str, Any], message: str) -> bool:
        """Change the parameters after a rejection of those `sent`. Returns whether another try makes sense."""
        text = message.lower()
        if not any(word in text for word in _REJECTIONS):
            return False
        with self._turn:
            if OLD_LIMIT in sent and OLD_LIMIT in text and NEW_LIMIT in text:
                self._rename_limit()
                return True
            if "temperature" in sent and "temperature" in text and "temperature" in self._defaults:
                self._leave_out("temperature")
                return True
        return False

    def _rename_limit(self) -> None:
        if OLD_LIMIT not in self._values:
            return  # another request has learned it
        value = self._values.pop(OLD_LIMIT)
        if OLD_LIMIT in self._defaults:
            value = max(value, REASONING_LIMIT)
        self._values[NEW_LIMIT] = value
        self._notes.append(f"the server rejects `{OLD_LIMIT}`; requests have {NEW_LIMIT}={value}")

    def _leave_out(self, name: str) -> None:
        if self._values.pop(name, None) is not None:
            self._notes.append(f"the server rejects `{name}`; requests leave it out")


#: Types of content parts that hold reasoning, and fields of a message that do.
_REASONING_PARTS = frozenset({"thinking", "reasoning", "redacted_thinking", "reasoning_text", "summary_text"})
_REASONING_FIELDS = ("reasoning_content", "reasoning", "thinking")


def read_response(done: Any, hide: Callable[[str], str]) -> Reply:
    """Return the reply in a response, without tokens and cost; `hide` removes secrets from a text.

    Raises ValueError, TypeError, LookupError or AttributeError if it is no chat completion.
    """
    if not done.choices:
        return Reply(error="the response has no choices")
    chosen = done.choices[0]
    text, thoughts = _content(chosen.message.content)
    thoughts = [_flat(getattr(chosen.message, name, None)) for name in _REASONING_FIELDS] + thoughts
    reasoning = "\n".join(dict.fromkeys(filter(None, thoughts)))
    refusal = getattr(chosen.message, "refusal", None)
    finish = chosen.finish_reason if isinstance(chosen.finish_reason, str) else None
    version = "/".join(str(part) for part in (done.model, getattr(done, "system_fingerprint", None)) if part)

    def safe(words: str, length: int | None = None) -> str:
        return storable(hide(words))[:length]  # shortened last, so that no part of a secret stays

    return Reply(
        text=safe(text),
        finish="refusal" if refusal else finish and safe(finish, 40),
        reasoning=safe(reasoning) or None,
        error=safe(str(refusal), 2000) if refusal else None,
        model_version=safe(version, 200) or None,
    )


def _content(content: Any) -> tuple[str, list[str]]:
    """Return the text of a message's content, a string or a list of parts, and the texts of its reasoning parts."""
    if content is None or isinstance(content, str):
        return content or "", []
    if not isinstance(content, Iterable):
        raise TypeError("the content is neither text nor a list of parts")
    texts: list[str] = []
    thoughts: list[str] = []
    for part in content:
        kind = part.get("type") if isinstance(part, dict) else ""
        (thoughts if kind in _REASONING_PARTS else texts).append(_flat(part))
    return "\n".join(filter(None, texts)), thoughts


def _flat(value: Any) -> str:
    """Return the words in a value: text, a part with text, or a list of these."""
    if isinstance(value, str):
        return value
    if isinstance(value, dict):
        known = ("text", "thinking", "reasoning", "content", "summary", "output_text")
        return next((_flat(value[name]) for name in known if value.get(name)), "")
    if isinstance(value, (list, tuple)):
        return "\n".join(filter(None, map(_flat, value)))
    return ""


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
