"""The interface of models."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

from wmspec.core.diagnostics import WmsError
from wmspec.eval.models.reply import MAX_REPLY_LENGTH
from wmspec.eval.models.request import Ask

#: How a request ended: with text, withheld by a filter, or without a reply.
Outcome = Literal["ok", "refused", "error"]


@dataclass(frozen=True)
class Reply:
    """A reply: text, version of the model, tokens, cost and seconds, where known."""

    text: str = ""
    outcome: Outcome = "ok"
    error: str | None = None
    model_version: str | None = None
    tokens_in: int | None = None
    tokens_out: int | None = None
    cost: float | None = None
    seconds: float | None = None


class Model(Protocol):
    """An open model. `identity` differs between models whose replies may differ; `asks` is the number of concurrent
    requests.
    """

    identity: str
    asks: int

    def reply(self, ask: Ask) -> Reply:
        """Return the reply to one request; thread-safe. An error of this request alone is a reply with outcome `error`.

        Raises WmsError if no request can succeed (a wrong key, an unknown model).
        """
        ...


class FatalModelError(WmsError):
    """No request to this model can succeed."""


def storable(text: str | None) -> str:
    """Return the text of a reply for storage: at most `LONGEST` characters, with invalid Unicode replaced."""
    return (text or "")[:MAX_REPLY_LENGTH].encode("utf-8", "replace").decode()
