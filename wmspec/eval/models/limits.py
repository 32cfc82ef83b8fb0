"""What a run may do: so many requests, so many of them a minute, so much cost."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass, field

from wmspec.core.diagnostics import WmsError
from wmspec.eval.models.model import Lost, Reply

#: Errors in a row after which nothing else is sent.
PATIENCE = 20


@dataclass(frozen=True)
class Limits:
    """At most so many requests in this run, so many a minute, and so much cost for the whole result; None: no limit."""

    requests: int | None = None
    a_minute: float | None = None
    cost: float | None = None


@dataclass
class Meter:
    """What a run has done of what it may. `spent` is what the result has cost before."""

    limits: Limits
    spent: float = 0.0
    sent: int = 0
    flying: int = 0
    _paid: int = 0
    _failed: int = 0
    _dearest: float = 0.0

    def may_send(self) -> bool:
        """Whether another request may go out now. Those on their way are taken to cost as much as the dearest so far.

        With a limit of cost the first request goes alone, to learn what one costs.
        """
        if self.limits.requests is not None and self.sent >= self.limits.requests:
            return False
        if self.limits.cost is None:
            return True
        if self._paid == 0 and self.flying:
            return False
        return self.spent + (self.flying + 1) * self._dearest <= self.limits.cost and self.spent < self.limits.cost

    def send(self) -> None:
        """A request goes out."""
        self.sent += 1
        self.flying += 1

    def receive(self, reply: Reply) -> None:
        """A reply has come. Raises Lost after `PATIENCE` errors in a row, and if a limited cost is not known."""
        self.flying -= 1
        self._failed = self._failed + 1 if reply.outcome == "error" else 0
        if self._failed >= PATIENCE:
            raise Lost(f"{PATIENCE} requests in a row have failed, the last with: {reply.error}")
        if reply.outcome == "error":
            return
        if reply.cost is None and self.limits.cost is not None:
            raise Lost("--max-cost: the server does not say what a reply costs; add --price IN OUT")
        self._paid += 1
        self.spent += reply.cost or 0.0
        self._dearest = max(self._dearest, reply.cost or 0.0)


@dataclass
class Pace:
    """Lets threads through evenly, so many a minute."""

    a_minute: float | None
    _next: float = 0.0
    _turn: threading.Lock = field(default_factory=threading.Lock)

    def __post_init__(self) -> None:
        if self.a_minute is not None and self.a_minute <= 0:
            raise WmsError("--rate: expected requests a minute, more than 0")

    def wait(self) -> None:
        """Return when it is this thread's turn."""
        if self.a_minute is None:
            return
        with self._turn:
            now = time.monotonic()
            turn = max(now, self._next)
            self._next = turn + 60 / self.a_minute
        time.sleep(turn - now)
