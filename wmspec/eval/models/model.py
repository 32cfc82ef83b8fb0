"""The interface of models."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Protocol

from wmspec.core.diagnostics import WmsError
from wmspec.eval.models.request import Ask
from wmspec.eval.replies import FINISHED_BY_FILTER, MAX_REPLY_LENGTH


@dataclass(frozen=True)
class Reply:
    """A reply: text, reasoning that came apart from it, version of the model, tokens, cost and seconds, where known.

    `finish` is the reason for which the model stopped, by the server's name. `error` says why no reply came, or what a
    filter said.
    """

    text: str = ""
    finish: str | None = None
    reasoning: str | None = None
    error: str | None = None
    model_version: str | None = None
    tokens_in: int | None = None
    tokens_out: int | None = None
    tokens_reasoning: int | None = None
    cost: float | None = None
    seconds: float | None = None

    @property
    def failed(self) -> bool:
        """Whether no reply came, so that the request is worth another try."""
        return self.error is not None and self.finish not in FINISHED_BY_FILTER


class Model(Protocol):
    """An open model. `identity` differs between models whose replies may differ; `asks` is the number of concurrent
    requests. `notes` are sentences about how it differs from what was requested.
    """

    identity: str
    asks: int

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences on changed requests, for the user."""
        ...

    def reply(self, ask: Ask) -> Reply:
        """Return the reply to one request; thread-safe. An error of this request alone is a reply with an `error`.

        Raises WmsError if no request can succeed (a wrong key, an unknown model).
        """
        ...


class FatalModelError(WmsError):
    """No request to this model can succeed."""


def storable(text: str | None) -> str:
    """Return the text of a reply for storage, with invalid Unicode replaced.

    Of more than `MAX_REPLY_LENGTH` characters, the beginning and the end are kept: either may hold the answer.
    """
    text = text or ""
    if len(text) > MAX_REPLY_LENGTH:
        half = MAX_REPLY_LENGTH // 2
        text = text[:half] + text[-half:]
    return re.sub(r"[\ud800-\udfff]", "\ufffd", text)
