"""Limits of a run: number, rate and cost of requests."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass, field

from wmspec.eval.models.model import FatalModelError, Reply

#: Maximum number of consecutive errors before the run stops.
MAX_CONSECUTIVE_ERRORS = 20


@dataclass(frozen=True)
class Limits:
    """Maximum number of requests, requests a minute, and cost of the whole result; None for no limit."""

    requests: int | None = None
    a_minute: float | None = None
    cost: float | None = None


@dataclass
class Meter:
    """Counts requests and cost against the limits. `spent` is the cost of earlier runs of the result."""

    limits: Limits
    spent: float = 0.0
    sent: int = 0
    flying: int = 0
    _paid: int = 0
    _failed: int = 0
    _dearest: float = 0.0

    def may_send(self) -> bool:
        """Return whether another request may be sent.

        Pending requests are assumed to cost as much as the dearest so far. With a cost limit, the first request is sent
        alone, to learn its cost.
        """
        if self.limits.requests is not None and self.sent >= self.limits.requests:
            return False
        if self.limits.cost is None:
            return True
        if self._paid == 0 and self.flying:
            return False
        return self.spent + (self.flying + 1) * self._dearest <= self.limits.cost and self.spent < self.limits.cost

    def send(self) -> None:
        """Count a request."""
        self.sent += 1
        self.flying += 1

    def receive(self, reply: Reply) -> None:
        """Count a reply.

        Raises FatalModelError after `MAX_CONSECUTIVE_ERRORS` consecutive errors, or if a limited cost is unknown.
        """
        self.flying -= 1
        self._failed = self._failed + 1 if reply.failed else 0
        if self._failed >= MAX_CONSECUTIVE_ERRORS:
            raise FatalModelError(
                f"{MAX_CONSECUTIVE_ERRORS} requests in a row have failed, the last with: {reply.error}"
            )
        if reply.failed:
            return
        if reply.cost is None and self.limits.cost is not None:
            raise FatalModelError("--max-cost: the server does not say what a reply costs; add --price IN OUT")
        self._paid += 1
        self.spent += reply.cost or 0.0
        self._dearest = max(self._dearest, reply.cost or 0.0)


@dataclass
class RateLimiter:
    """Spaces the requests of all threads evenly."""

    a_minute: float | None
    _next: float = 0.0
    _turn: threading.Lock = field(default_factory=threading.Lock)

    def wait(self) -> None:
        """Block until the next request may be sent."""
        if self.a_minute is None:
            return
        with self._turn:
            now = time.monotonic()
            turn = max(now, self._next)
            self._next = turn + 60 / self.a_minute
        time.sleep(turn - now)
