"""Whether a run failed as a whole: nothing was made, or too many units ended in errors."""

from __future__ import annotations

from dataclasses import dataclass

#: The largest accepted share of units that end as internal errors, crashes or timeouts.
MAX_FAILED_SHARE = 0.1


@dataclass(frozen=True)
class Tally:
    """Counts of a run: of `tried` units, `failed` ended by an internal error, a crash or a timeout.

    `made` counts the results, such as questions or pictures, and `product` is the clause for one of them. `most` is the
    accepted share of failures, `cause` the first failure in full, `how` the verb phrase for failures.
    """

    product: str
    made: int
    unit: str = ""
    tried: int = 0
    failed: int = 0
    cause: str = ""
    how: str = "ended as internal errors, crashes or timeouts"
    most: float = MAX_FAILED_SHARE

    @property
    def passed(self) -> bool:
        """Whether something was made and not too much failed."""
        return self.made > 0 and self.failed <= self.most * self.tried

    @property
    def message(self) -> str:
        """The failures as text, with the first cause; empty if there are none."""
        lines = [] if self.made else [f"error: no {self.product}"]
        if self.failed:
            label = "warning" if self.passed else "error"
            few = f"{self.failed:,} of {self.tried:,} {self.unit} {self.how}"
            lines.append(f"{label}: {few}" + (f"; the first: {self.cause}" if self.cause else ""))
        return "\n".join(lines)
