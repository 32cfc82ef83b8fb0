"""What is wrong with a design, as the checker reports it: a code, the place, the other places involved, a remedy."""

from __future__ import annotations

from wmspec.check.ir import Location
from wmspec.errors import WmsError


class Fault(WmsError):
    """A design that cannot be made. `notes` are further sentences with their places."""

    def __init__(
        self, code: str, message: str, place: Location, help: str = "", notes: tuple[tuple[str, Location], ...] = ()
    ) -> None:
        self.code = code
        self.message = message
        self.place = place
        self.help = help
        self.notes = notes
        told = "".join(f"; {where}: {note}" for note, where in notes)
        super().__init__(f"{place}: {message}{told}" + (f"; {help}" if help else ""))

    def __reduce__(self) -> tuple[type[Fault], tuple[object, ...]]:
        """Cross from a worker process to its parent whole."""
        return Fault, (self.code, self.message, self.place, self.help, self.notes)
