"""What a probe could have found: the smallest shortcut that it tells from chance in four of five datasets.

Two things hide a shortcut: the dice, because few questions are answered by luck more often than others, and the
classifier, which has to learn it from the same few. The first is worked out. The second is tried: shortcuts of known
sizes are planted into what the probe sees, and it is seen how much of them it answers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from statistics import NormalDist

import numpy as np

from wmspec.dataset.audit.classify import SEED, Array, Asked, Seen, held_out

#: The share of datasets without a shortcut that may be said to have one, by all probes of a task together.
ALARMS = 0.05
#: The share of datasets with a shortcut in which it has to be found.
POWER = 0.8
#: The sizes that are planted, above chance, and how often each: forests take longer.
SIZES, PLANTED = (0.1, 0.2, 0.3), {"linear": 16, "forest": 8}


#: A number that has fewer values, or in fewer of the questions one largest, has no room for a shortcut.
VALUES, ABLE = 20, 0.9
#: What is larger by less than this share of how much a number varies is not clearly so.
LARGER = 0.1

#: How much more a probe's accuracy varies than that of answers given one by one, since what answers the parts has been
#: fitted to most of the same questions: measured on noise, 1.16 to 1.2 in three settings of 40 to 100 draws.
SHARED = 1.2


def deviation(right: Array, chance: Array, groups: Sequence[str]) -> float:
    """The standard deviation of a probe's accuracy: by chance alone, or as groups differ if that is more.

    Questions of a group are alike, so that what is right of one is apt to be right of all (clustered sampling).
    """
    alone = float(np.sqrt((chance * (1 - chance)).sum())) / len(right)
    number = np.unique(groups, return_inverse=True)[1]
    sums = np.bincount(number, right - right.mean())
    many = len(sums)
    clustered = float(np.sqrt((sums**2).sum() * many / max(1, many - 1))) / len(right)
    return SHARED * max(alone, clustered)


@dataclass(frozen=True)
class Reach:
    """What is known of a probe before it is looked at what it answers: its `chance`, the `deviation` of its accuracy.

    `learned` is how far above chance it gets, in four of five datasets, with a shortcut of each of the `SIZES`; None
    if there is nothing to learn.
    """

    chance: float
    deviation: float
    learned: Sequence[float] | None

    def gained(self, size: float) -> float:
        """How far above chance it gets in four of five datasets with a shortcut of this size, in deviations."""
        if self.learned is not None:
            got = float(np.interp(size, [0.0, *SIZES], np.maximum.accumulate([0.0, *self.learned])))
        else:
            share = min(self.chance + size, 1.0)
            wider = np.sqrt(share * (1 - share) / max(self.chance * (1 - self.chance), 1e-12))
            got = size - NormalDist().inv_cdf(POWER) * self.deviation * float(wider)
        return got / self.deviation


def threshold(tests: int, alarms: float = ALARMS) -> float:
    """How many standard deviations above chance is more than luck, in so many tests (Bonferroni)."""
    return NormalDist().inv_cdf(1 - alarms / max(1, tests))


def thresholds(reaches: Sequence[Reach]) -> list[float]:
    """The same of each of a task's probes: half of the alarms are shared out evenly, half to those that find least.

    These get so much that all find a shortcut of the same size, the smallest that can be had (weights by power, as in
    Roeder & Wasserman 2009). If none of `SIZES` can be had, all alarms are shared out evenly.
    """
    for size in np.arange(0.01, SIZES[-1] + 0.001, 0.01):
        needed = [reach.gained(float(size)) for reach in reaches]
        if sum(1 - NormalDist().cdf(beyond) for beyond in needed) <= ALARMS / 2:
            return [min(beyond, threshold(len(reaches), ALARMS / 2)) for beyond in needed]
    return [threshold(len(reaches))] * len(reaches)


def learned(seen: Seen, asked: Asked, chance: Array) -> tuple[float, ...]:
    """Of shortcuts of each of the sizes: how far above chance the probe gets in four of five datasets."""
    random = np.random.default_rng(SEED)
    times = range(PLANTED[seen.model])
    return least_gained(
        [[float((held_out(*planted(seen, asked, size, random)) - chance).mean()) for _ in times] for size in SIZES]
    )


def least_gained(gained: Sequence[Sequence[float]]) -> tuple[float, ...]:
    """What is gained of shortcuts of each size in four of five datasets, from what was gained of some (sizes, times).

    How much they differ, by luck and by what was learned, is taken to be the same for all sizes. Few are tried, so it
    is what is gained at the least, by one standard error.
    """
    of_sizes = np.array(gained)
    means, times = of_sizes.mean(1), of_sizes.shape[1]
    spread = float(np.sqrt(((of_sizes - means[:, None]) ** 2).sum() / (of_sizes.size - len(means))))
    return tuple(float(mean) for mean in means - (NormalDist().inv_cdf(POWER) + times**-0.5) * spread)


def smallest(reach: Reach, beyond: float) -> float:
    """The smallest shortcut that is told from luck in four of five datasets; 1 if none that was tried.

    More than luck is what is more than `beyond` deviations above chance.
    """
    sizes = np.arange(0.0, (1.0 if reach.learned is None else SIZES[-1]) + 1e-9, 0.002)
    found = [size for size in sizes if reach.gained(float(size)) >= beyond - 1e-9]
    return max(float(found[0]), beyond * reach.deviation) if found else 1.0


def planted(seen: Seen, asked: Asked, size: float, random: np.random.Generator) -> tuple[Seen, Asked]:
    """The same with another truth, drawn at random, and one number of what is seen that tells it.

    It tells it in so many questions that whoever reads it is right `size` above chance, and lies in the others.
    """
    count = asked.sizes
    places = (random.random(asked.count) * count).astype(np.int64)
    retold = asked.retold(places)
    tells = random.random(asked.count) < size / (1 - (1 / count).mean())
    claimed = np.where(tells, places, (random.random(asked.count) * count).astype(np.int64))
    features = seen.features.copy()
    of_options = seen.of == "options"
    able = _only_best(features, asked) if of_options else _values(features)
    column = _telling(features, able, random)
    if able[column] < ABLE:  # no number has room
        features[:, column] = random.random(len(features))
    if of_options:
        features[:, column] = _first(features[:, column], asked, claimed, random)
    else:
        features[:, column] = _banded(features[:, column], asked.name[asked.starts + claimed], random)
    return replace(seen, features=features), retold


def _telling(features: Array, able: Array, random: np.random.Generator) -> int:
    """A number that a shortcut may be in: one of the eight that vary most, of those most `able` (0 to 1) to tell it."""
    possible = np.flatnonzero(able >= min(ABLE, able.max()))
    widest = possible[np.argsort(-features[:, possible].std(0), kind="stable")][:8]
    return int(widest[random.integers(len(widest))])


def _values(features: Array) -> Array:
    """Whether each has as many values as a shortcut has room in: (d,), at most 1."""
    return np.array([min(1.0, len(np.unique(column.round(9))) / VALUES) for column in features.T])


def _only_best(features: Array, asked: Asked) -> Array:
    """In how many of the questions one option has a number that is clearly the largest: (d,)."""
    largest = np.repeat(np.maximum.reduceat(features, asked.starts), asked.sizes, axis=0)
    near = features >= largest - np.maximum(LARGER * features.std(0), 1e-9)
    having = np.add.reduceat(near.astype(np.float64), asked.starts)
    return np.asarray((having == 1).mean(0))


def _first(column: Array, asked: Asked, claimed: np.ndarray, random: np.random.Generator) -> Array:
    """The numbers of each question's options in random order, the largest where the truth is said to be."""
    put = column.copy()
    for start, size, place in zip(asked.starts, asked.sizes, claimed, strict=True):
        values = random.permutation(column[start : start + size])
        best = int(values.argmax())
        values[[best, place]] = values[[place, best]]
        put[start : start + size] = values
    return put


def _banded(column: Array, groups: np.ndarray, random: np.random.Generator) -> Array:
    """The same numbers, so that each of the names has a band of them for itself."""
    order = np.argsort(np.unique(groups, return_inverse=True)[1] + random.random(len(groups)), kind="stable")
    put = np.empty_like(column)
    put[order] = np.sort(column)
    return put
