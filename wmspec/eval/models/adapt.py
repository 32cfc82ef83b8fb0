"""Parameters that a server rejects, and what is sent instead. Learned from its first rejection, for all requests."""

from __future__ import annotations

import threading
from typing import Any

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
