"""Studies: the questions, and each participant's steps in order. A study is an immutable file."""

from __future__ import annotations

import hashlib
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

from pydantic import ValidationError

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import read_bytes
from wmspec.dataset.build.format_units import DISPLAY_UNITS
from wmspec.eval.models.prompt import FrozenModel
from wmspec.eval.models.question import Question
from wmspec.eval.models.results import write_atomically
from wmspec.eval.replies import LETTERS

#: The study's file, the page's folder, and the folder of editable texts.
STUDY_FILE, PAGE_FOLDER, TEXTS_FOLDER = "study.json", "page", "texts"

Kind = Literal["question", "practice", "check"]


class Item(FrozenModel):
    """A question of a dataset with the names of its pictures and of its film, or an attention check.

    `answer` is the position of the true option among `words` or `pictures`, None for an open question.
    """

    id: str
    kind: Kind
    task: str
    text: str
    context: tuple[str, ...] = ()
    film: str = ""
    words: tuple[str, ...] = ()
    pictures: tuple[str, ...] = ()
    answer: int | None = None
    number: float | None = None
    unit: str = ""
    within: float | None = None
    dimension: str = ""
    name: str = ""
    engine: str = ""
    index: int = 0
    block: int = 0

    @property
    def options(self) -> tuple[str, ...]:
        """The words or pictures to choose from; empty if the question is open."""
        return self.words or self.pictures

    @property
    def shown_unit(self) -> str:
        """The unit shown to people, such as cm for metres."""
        return DISPLAY_UNITS.get(self.unit, (self.unit, 1.0))[0]

    def order(self, permutation: int) -> tuple[int, ...]:
        """Return the indices of the options as shown."""
        count = len(self.options)
        return tuple((place + permutation) % count for place in range(count))

    def is_right(self, text: str, permutation: int) -> bool:
        """Whether a letter is that of the true option."""
        return self.answer is not None and LETTERS[self.order(permutation).index(self.answer)] == text

    def question(self) -> Question:
        """Return the question for results, without pictures."""
        options: tuple[str | None, ...] = self.words or (None,) * len(self.pictures)
        return Question(
            self.id, self.task, self.dimension, self.name, self.engine, self.index, self.block, self.text, (), options,
            (), (), self.answer, self.number, self.unit, self.within,
        )  # fmt: skip


class Step(FrozenModel):
    """One step of a participant: an item, and the rotation of its options."""

    item: int
    permutation: int = 0


class Study(FrozenModel):
    """A study. `slots` has the steps of each participant; every question occurs in `raters` of them, once each."""

    format: Literal[1] = 1
    title: str
    dataset: str
    seed: int
    raters: int
    items: tuple[Item, ...]
    slots: tuple[tuple[Step, ...], ...]

    @cached_property
    def fingerprint(self) -> str:
        """Twelve hex digits that identify the content of the study."""
        return hashlib.sha256(self.model_dump_json().encode()).hexdigest()[:12]

    def step(self, slot: int, step: int) -> tuple[Item, int] | None:
        """Return the item of a participant's step and its permutation, None if there is no such step."""
        if not (0 <= slot < len(self.slots) and 0 <= step < len(self.slots[slot])):
            return None
        shown = self.slots[slot][step]
        return self.items[shown.item], shown.permutation

    def public(self) -> dict[str, Any]:
        """Return the data of the page; true answers only for practice."""
        return {
            "study": self.fingerprint,
            "title": self.title,
            "items": [_public(item) for item in self.items],
            "slots": [[[step.item, step.permutation] for step in slot] for slot in self.slots],
        }


def _public(item: Item) -> dict[str, Any]:
    fields = item.model_dump(include={"kind", "task", "text", "context", "film", "words", "pictures"})
    practice = {"answer": item.answer, "truth": _truth(item)} if item.kind == "practice" else {}
    return fields | {"unit": item.shown_unit, "open": not item.options} | practice


def _truth(item: Item) -> list[float] | None:
    """Return the true number of an open question and its tolerance, in the unit shown."""
    if item.number is None:
        return None
    scale = DISPLAY_UNITS.get(item.unit, ("", 1.0))[1]
    return [item.number * scale, (item.within or 0.0) * scale]


def load(folder: Path) -> Study:
    """Load the study in a folder. Raises WmsError if there is none, or if its file is damaged."""
    path = folder / STUDY_FILE
    try:
        return Study.model_validate_json(read_bytes(path))
    except OSError:
        raise WmsError(f"{folder} holds no study; make one with `wmspec study make DATASET -o {folder}`") from None
    except ValidationError:
        raise WmsError(
            "not a study that `wmspec study make` wrote", FilePlace(str(path)), "make it again, with the same options"
        ) from None


def save(study: Study, folder: Path) -> None:
    """Write a study's file. Raises WmsError if it cannot be written."""
    write_atomically(folder / STUDY_FILE, (study.model_dump_json(exclude_defaults=True) + "\n").encode())
