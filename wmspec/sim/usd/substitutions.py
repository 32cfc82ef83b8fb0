"""What of a stage is taken for something else: told once, with its prim and a warning; or refused, where that is asked.

Only what is seen, and what can be executed nearly as it is meant, has a stand-in. What would move otherwise is refused.
"""

from __future__ import annotations

from pxr import Usd

from wmspec.core.diagnostics import Diagnostic, Report, StageError
from wmspec.core.places import PrimPlace


class Notes:
    """Collects the warnings of one reading; a strict reader has none, but refuses."""

    def __init__(self, *, strict: bool) -> None:
        self.strict = strict
        self._report = Report(StageError)

    def instead(self, prim: Usd.Prim, reason: str, taken: str, remedy: str) -> None:
        """Tell what is `taken` for what cannot be had.

        Raises:
            StageError: with the reason and the remedy, if the reader is strict.
        """
        place = PrimPlace(str(prim.GetPath()))
        if self.strict:
            raise StageError(reason, place, remedy)
        self._report.add("", f"{reason}: {taken}", place, remedy, severity="warning")

    def rather(self, error: StageError, taken: str) -> None:
        """Tell what is `taken` for what an error is about. Raises the error if the reader is strict."""
        if self.strict:
            raise error
        for d in error.diagnostics:
            self._report.add("", f"{d.message}: {taken}", d.place, d.help, severity="warning")

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """The warnings, each once, in the order in which the stage was read."""
        return self._report.diagnostics


STRICT = Notes(strict=True)
"""The reader that has no stand-ins; it collects nothing."""
