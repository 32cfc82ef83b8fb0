"""Substitutions made while reading a stage: a warning with its prim, or an error in strict mode.

Only visuals and features that can be approximated are substituted. A feature whose loss would change motion is refused.
"""

from __future__ import annotations

from pxr import Usd

from wmspec.core.diagnostics import Diagnostic, Report, StageError
from wmspec.core.places import PrimPlace


class Substitutions:
    """Collects the warnings of one reading; in strict mode it raises."""

    def __init__(self, *, strict: bool) -> None:
        self.strict = strict
        self._report = Report(StageError)

    def record(self, prim: Usd.Prim, reason: str, taken: str, remedy: str) -> None:
        """Record that `taken` replaces an unsupported feature.

        Raises: StageError: with reason and remedy, in strict mode.
        """
        place = PrimPlace(str(prim.GetPath()))
        if self.strict:
            raise StageError(reason, place, remedy)
        self._report.add("", f"{reason}: {taken}", place, remedy, severity="warning")

    def record_error(self, error: StageError, taken: str) -> None:
        """Record that `taken` replaces the subject of an error. Raises the error in strict mode."""
        if self.strict:
            raise error
        for d in error.diagnostics:
            self._report.add("", f"{d.message}: {taken}", d.place, d.help, severity="warning")

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Return the warnings without duplicates, in reading order."""
        return self._report.diagnostics


STRICT = Substitutions(strict=True)
"""Strict mode: no substitutions, collects nothing."""
