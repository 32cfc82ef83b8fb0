"""The best of many probes: picked by some questions, judged by the others.

A question that shows ten pictures has a hundred probes that see one or two of them. The best of a hundred gets far by
luck, and what allows for that hides true shortcuts. So it is said beforehand how the one to be judged is picked: for
each fold of questions, the one that does best where nothing of that fold was seen.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.audit.classify import SEED, Array, Asked, Seen, held_out, held_out_twice
from wmspec.dataset.audit.power import SIZES, least_gained, planted

#: How often a shortcut of each size is planted into one of them, drawn at random.
PLANTED = 12


@dataclass(frozen=True)
class Rivals:
    """How right each of some probes is of every question.

    `right` (probes, questions) by classifiers that were fitted to the other folds, `picks` (probes, folds) in the
    mean of the other folds, by classifiers that saw neither the fold nor what they tell of.
    """

    right: Array
    picks: Array

    @classmethod
    def of(cls, seen: Sequence[Callable[[], Seen]], asked: Asked) -> Rivals:
        """Those that see this."""
        right, picks = zip(*(_tried(look(), asked) for look in seen), strict=True)
        return cls(np.stack(right), np.stack(picks))

    def best(self, asked: Asked) -> tuple[Array, NDArray[np.int64]]:
        """How right the best is of every question, and which it is for each fold; the first where several are."""
        picked = self.picks.round(9).argmax(0)
        judged = np.zeros(asked.count)
        for held, probe in zip(asked.folds, picked, strict=True):
            judged[held] = self.right[probe, held]
        return judged, picked

    def learned(self, seen: Sequence[Callable[[], Seen]], asked: Asked, chance: Array) -> tuple[float, ...]:
        """Of shortcuts of each of the `SIZES` in one of them: how far the best gets in four of five datasets.

        The others answer as they do.
        """
        random = np.random.default_rng(SEED)
        return least_gained([[self._gained(seen, asked, chance, s, random) for _ in range(PLANTED)] for s in SIZES])

    def _gained(
        self, seen: Sequence[Callable[[], Seen]], asked: Asked, chance: Array, size: float, random: np.random.Generator
    ) -> float:
        told = int(random.integers(len(seen)))
        right, picks = self.right.copy(), self.picks.copy()
        right[told], picks[told] = _tried(*planted(seen[told](), asked, size, random))
        return float((replace(self, right=right, picks=picks).best(asked)[0] - chance).mean())


def _tried(seen: Seen, asked: Asked) -> tuple[Array, Array]:
    others = asked.count - np.array([len(held) for held in asked.folds])
    return held_out(seen, asked), held_out_twice(seen, asked).sum(1) / others
