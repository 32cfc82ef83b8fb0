"""Selection of the best of many probes on some questions, and its evaluation on the others.

A question with ten pictures has a hundred probes that see one or two of them. The best of a hundred is high by luck,
and a correction for that hides true shortcuts. Therefore the selection is nested: in each fold, the probe that does
best without any data of the fold is evaluated.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.audit.classify import (
    SEED,
    Array,
    ProbeDataset,
    ProbeFeatures,
    cross_validated_scores,
    nested_scores,
)
from wmspec.dataset.audit.power import SHORTCUT_SIZES, gain_quantile, inject_shortcut

#: Number of injections of a shortcut of each size, each into a random probe.
INJECTIONS = 9


@dataclass(frozen=True)
class CandidateProbes:
    """Scores of candidate probes.

    `right` (probes, questions) comes from classifiers fitted to the other folds. `picks` (probes, folds) is the mean
    score outside a fold, by classifiers that saw neither the fold nor the question.
    """

    right: Array
    picks: Array

    @classmethod
    def of(cls, seen: Sequence[Callable[[], ProbeFeatures]], data: ProbeDataset) -> CandidateProbes:
        """Return the scores of probes with these inputs."""
        right, picks = zip(*(_tried(look(), data) for look in seen), strict=True)
        return cls(np.stack(right), np.stack(picks))

    def best(self, data: ProbeDataset) -> tuple[Array, NDArray[np.int64]]:
        """Return the score of every question by the selected probe, and the probe selected in each fold."""
        picked = self.picks.round(9).argmax(0)
        judged = np.zeros(data.count)
        for held, probe in zip(data.folds, picked, strict=True):
            judged[held] = self.right[probe, held]
        return judged, picked

    def learned(
        self, seen: Sequence[Callable[[], ProbeFeatures]], data: ProbeDataset, chance: Array
    ) -> tuple[float, ...]:
        """Return the selected probe's gain, with a power of 0.8, from a shortcut in one of the probes.

        One value for each of the `SHORTCUT_SIZES`. The other probes keep their scores.
        """
        random = np.random.default_rng(SEED)
        return gain_quantile(
            [[self._gained(seen, data, chance, s, random) for _ in range(INJECTIONS)] for s in SHORTCUT_SIZES]
        )

    def _gained(
        self,
        seen: Sequence[Callable[[], ProbeFeatures]],
        data: ProbeDataset,
        chance: Array,
        size: float,
        random: np.random.Generator,
    ) -> float:
        injected = int(random.integers(len(seen)))
        right, picks = self.right.copy(), self.picks.copy()
        right[injected], picks[injected] = _tried(*inject_shortcut(seen[injected](), data, size, random))
        return float((replace(self, right=right, picks=picks).best(data)[0] - chance).mean())


def _tried(seen: ProbeFeatures, data: ProbeDataset) -> tuple[Array, Array]:
    others = data.count - np.array([len(held) for held in data.folds])
    return cross_validated_scores(seen, data), nested_scores(seen, data).sum(1) / others
