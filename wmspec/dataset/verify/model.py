"""Results of a verification."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

Verdict = Literal["same", "near", "different"]


@dataclass(frozen=True)
class Difference:
    """A difference: the id of a question or the path of a file, the column (or ''), a description.

    `near` differences are small enough to come from another graphics driver or processor.
    """

    id: str
    column: str
    words: str
    near: bool = False

    def __str__(self) -> str:
        return f"{self.id}: {self.column}: {self.words}" if self.column else f"{self.id}: {self.words}"


@dataclass(frozen=True)
class Power:
    """What the random sample finds: changes in `share` of the questions, with probability `found`."""

    share: float
    found: float


@dataclass(frozen=True)
class Verification:
    """The result of a verification.

    `questions` of all `planned` were generated again; the others were checked against spec and seed. `differences` has
    the first one of each question or file that differs. `versions` maps packages whose installed version differs to
    (version in the dataset, version installed). `limits` are sentences about what was not compared. `sample_seed`
    draws the same sample again.
    """

    questions: int
    planned: int
    differences: tuple[Difference, ...]
    versions: Mapping[str, tuple[str, str]]
    power: Power
    limits: tuple[str, ...] = ()
    sample_seed: int = 0

    @property
    def verdict(self) -> Verdict:
        """The worst verdict of all differences."""
        if not self.differences:
            return "same"
        return "near" if all(difference.near for difference in self.differences) else "different"
