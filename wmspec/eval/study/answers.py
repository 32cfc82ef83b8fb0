"""People's answers, from the server or from the files that the page saves without one."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field, ValidationError

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import read_bytes, regular_file
from wmspec.eval.models.prompt import FrozenModel
from wmspec.eval.replies import LETTERS
from wmspec.eval.study.model import Item, Study

#: Maximum size of a file of answers (bytes).
MAX_FILE_BYTES = 16 << 20
_DAY = 86_400.0

Seconds = Annotated[float, Field(ge=0, le=_DAY, allow_inf_nan=False)]

Linked = Annotated[str, Field(pattern=r"^[A-Za-z0-9._-]{0,64}$")]


class Person(FrozenModel):
    """A participant: a random session id, and the name in the link, if any.

    `study_id` and `session_id` are those of the site that invites people, such as Prolific.
    """

    session: str = Field(pattern=r"^[0-9a-f]{32}$")
    rater: Linked = ""
    study_id: Linked = ""
    session_id: Linked = ""


class Answer(FrozenModel):
    """An answer: its step, the chosen letter or number, its time (s), and the time during which the page was hidden
    (s).
    """

    step: int = Field(ge=0, le=100_000)
    text: str = Field(pattern=r"^(?:[A-Z]|-?[0-9]{1,9}(?:\.[0-9]{1,9})?)$")
    seconds: Seconds
    away: Seconds = 0.0

    def fits(self, item: Item) -> bool:
        """Whether this is a valid answer to the item: one of its letters, or a number."""
        return self.text in LETTERS[: len(item.options)] if item.options else self.text not in LETTERS


class Visit(Person):
    """One participant's answers, as a file."""

    study: str
    slot: int
    code: str = Field(default="", max_length=32)
    answers: tuple[Answer, ...]


def read(path: Path, study: Study) -> Visit:
    """Read a file of answers. Raises WmsError if it is invalid, or belongs to another study."""
    try:
        if regular_file(path).stat().st_size > MAX_FILE_BYTES:
            raise WmsError(
                f"more than {MAX_FILE_BYTES >> 20} MiB: too large for a file of answers", FilePlace(str(path))
            )
        visit = Visit.model_validate_json(read_bytes(path))
    except OSError as error:
        raise WmsError(f"cannot be read: {error.strerror}", FilePlace(str(path))) from None
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        message = f"not a file of answers{f' ({where})' if where else ''}"
        raise WmsError(message, FilePlace(str(path)), "the page of a study gives them at its end") from None
    if visit.study != study.fingerprint:
        raise WmsError("answers to another study", FilePlace(str(path)), "give the folder of the study that was shown")
    steps = [(answer, study.step(visit.slot, answer.step)) for answer in visit.answers]
    wrong = [answer.step for answer, shown in steps if shown is None or not answer.fits(shown[0])]
    if wrong:
        raise WmsError(f"the answer of step {wrong[0]} is not one of its options", FilePlace(str(path)))
    return visit
