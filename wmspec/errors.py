"""The one exception that a user's mistake may raise; the command line prints it and exits with code 2."""

from __future__ import annotations

from dataclasses import dataclass


class WmsError(Exception):
    """A mistake in what the user gave us (a stage, a setting, a missing engine), said in a sentence with its remedy."""


@dataclass(frozen=True)
class Problem:
    """What is wrong with a prim of a stage: its path, the reason, and what the user can do about it."""

    path: str
    reason: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.path}: {self.reason}; {self.remedy}"


class StageError(WmsError):
    """A stage cannot be executed; `problems` holds everything that is wrong with it."""

    def __init__(self, problems: tuple[Problem, ...]) -> None:
        self.problems = problems
        super().__init__("\n".join(map(str, problems)))

    def __reduce__(self) -> tuple[type[StageError], tuple[tuple[Problem, ...]]]:
        """Cross from a worker process to its parent whole."""
        return StageError, (self.problems,)


class EngineError(WmsError):
    """An engine gave up or returned nonsense for this episode (a diverged state, a warning that it hides)."""
