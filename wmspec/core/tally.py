"""Whether a run has failed as a whole: nothing was made, or too much of it ended in errors."""

from __future__ import annotations

from dataclasses import dataclass

#: A run in which a larger share than this ended as internal errors, crashes or timeouts has failed.
MOST_FAILED = 0.1


@dataclass(frozen=True)
class Tally:
    """The count of a run: of so many `tried` units, so many `failed` by an internal error, a crash or a timeout.

    `made` is how much the run was for: questions, pictures, comparisons, replies, rows, as `product` calls one of them.
    `most` is the share of failures that is still accepted, `cause` the first failure in full, `how` they failed.
    """

    product: str
    made: int
    unit: str = ""
    tried: int = 0
    failed: int = 0
    cause: str = ""
    how: str = "ended as internal errors, crashes or timeouts"
    most: float = MOST_FAILED

    @property
    def passed(self) -> bool:
        """Whether something was made, and not too much failed."""
        return self.made > 0 and self.failed <= self.most * self.tried

    @property
    def told(self) -> str:
        """What went wrong, with the first cause; empty if nothing did."""
        lines = [] if self.made else [f"error: no {self.product}"]
        if self.failed:
            label = "warning" if self.passed else "error"
            few = f"{self.failed:,} of {self.tried:,} {self.unit} {self.how}"
            lines.append(f"{label}: {few}" + (f"; the first: {self.cause}" if self.cause else ""))
        return "\n".join(lines)
