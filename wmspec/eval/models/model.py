"""What a model is to the rest: something that replies to an asking."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

from wmspec.core.diagnostics import WmsError
from wmspec.eval.models.reply import LONGEST
from wmspec.eval.models.request import Ask

#: How a reply came: as text, withheld by a filter, or not at all.
Outcome = Literal["ok", "refused", "error"]


@dataclass(frozen=True)
class Reply:
    """What came back: the text, who gave it, the tokens, the cost and the seconds that it took, as far as known."""

    text: str = ""
    outcome: Outcome = "ok"
    error: str | None = None
    model_version: str | None = None
    tokens_in: int | None = None
    tokens_out: int | None = None
    cost: float | None = None
    seconds: float | None = None


class Model(Protocol):
    """A model, opened. `identity` tells it from all whose replies may differ; it takes `asks` askings at a time."""

    identity: str
    asks: int

    def reply(self, ask: Ask) -> Reply:
        """The reply to one asking, from any thread. What goes wrong with it alone is a reply of outcome `error`.

        Raises WmsError if no asking can come to anything (a wrong key, an unknown model).
        """
        ...


class Lost(WmsError):
    """Nothing that this model is asked will come to anything."""


def kept(text: str | None) -> str:
    """A reply's text as it is kept: at most `LONGEST` characters, whatever is not Unicode replaced."""
    return (text or "")[:LONGEST].encode("utf-8", "replace").decode()
