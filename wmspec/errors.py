"""The one exception that a user's mistake may raise; the command line prints it and exits with code 2."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
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


class Several(WmsError):
    """Mistakes that have nothing to do with one another; `errors` are two or more."""

    def __init__(self, errors: tuple[WmsError, ...]) -> None:
        self.errors = errors
        super().__init__("\n".join(map(str, errors)))

    def __reduce__(self) -> tuple[type[Several], tuple[tuple[WmsError, ...]]]:
        """Cross from a worker process to its parent whole."""
        return Several, (self.errors,)


class Gathered:
    """Goes on after mistakes, so that all can be told: `with gathered: ...` for each step, then `gathered.stop()`."""

    def __init__(self) -> None:
        self._found: dict[str, WmsError] = {}

    def __enter__(self) -> None:
        """Begin a step."""

    def __exit__(self, kind: object, error: BaseException | None, traceback: object) -> bool:
        """End a step; a mistake that another step has found is the same one."""
        if isinstance(error, WmsError):
            self._found.setdefault(str(error), error)
        return isinstance(error, WmsError)

    def stop(self) -> None:
        """Raise what was found, if anything was: the one WmsError, or `Several`."""
        if len(self._found) > 1:
            raise Several(tuple(self._found.values()))
        for error in self._found.values():
            raise error


class EngineError(WmsError):
    """An engine gave up or returned nonsense for this episode (a diverged state, a warning that it hides)."""


class GraphicsError(WmsError):
    """This machine cannot draw with an engine: nothing that an episode could be blamed for."""


def suggestion(word: str, known: Iterable[str]) -> str:
    """`did you mean X?` for the known word closest to `word`, or a list of a few known ones, or nothing."""
    names = sorted(set(known))
    close = difflib.get_close_matches(word, names, n=1, cutoff=0.6)
    if close:
        return f"did you mean `{close[0]}`?"
    if 0 < len(names) <= 16:
        return "known here: " + ", ".join(names)
    return ""
