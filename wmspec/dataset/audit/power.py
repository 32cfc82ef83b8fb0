"""Power of probes: the smallest shortcut that a probe detects with a power of 0.8.

Two effects hide a shortcut: chance, because questions are few, and learning, because the classifier has to find the
shortcut from the same few questions. Chance is computed. Learning is measured: shortcuts of known sizes are injected
into the features, and the gain in accuracy is recorded.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from statistics import NormalDist

import numpy as np

from wmspec.dataset.audit.classify import SEED, Array, ProbeDataset, ProbeFeatures, cross_validated_scores
from wmspec.dataset.audit.model import Probe

#: Probability of a false alarm by any probe of a task without a shortcut.
FALSE_ALARMS = 0.05
#: Probability of detecting an existing shortcut.
POWER = 0.8
#: Sizes of injected shortcuts (accuracy above chance), and the number of injections by model. Gains are convex in the
#: size: interpolated between sizes further apart, they are overestimated.
SHORTCUT_SIZES, INJECTIONS = (0.1, 0.15, 0.2, 0.3), {"linear": 12, "forest": 6}


#: Minimum number of values of a feature, and minimum share of questions with a single largest value, to hold a
#: shortcut.
MIN_VALUES, MIN_UNIQUE_MAXIMA = 20, 0.9
#: Minimum lead of the largest value, relative to the spread of the feature.
MIN_LEAD = 0.1

#: Factor by which the deviation of a cross-validated accuracy exceeds that of independent answers, since the folds
#: share most of their training data. Measured on noise: 1.16 to 1.2 in three settings of 40 to 100 draws.
FOLD_INFLATION = 1.2


def deviation(right: Array, chance: Array, groups: Sequence[str]) -> float:
    """Return the standard deviation of a probe's accuracy: that of chance, or that between groups if larger.

    Questions of a group are correlated (cluster sampling).
    """
    alone = float(np.sqrt((chance * (1 - chance)).sum())) / len(right)
    number = np.unique(groups, return_inverse=True)[1]
    sums = np.bincount(number, right - right.mean())
    many = len(sums)
    clustered = float(np.sqrt((sums**2).sum() * many / max(1, many - 1))) / len(right)
    return FOLD_INFLATION * max(alone, clustered)


def _gained(probe: Probe, size: float) -> float:
    """Return a probe's gain above chance from a shortcut of this size, with a power of 0.8, in deviations."""
    if probe.learned is not None:
        got = float(np.interp(size, [0.0, *SHORTCUT_SIZES], np.maximum.accumulate([0.0, *probe.learned])))
    else:  # nothing can be learned
        share = min(probe.chance + size, 1.0)
        wider = np.sqrt(share * (1 - share) / max(probe.chance * (1 - probe.chance), 1e-12))
        got = size - NormalDist().inv_cdf(POWER) * probe.deviation * float(wider)
    return got / probe.deviation


def threshold(tests: int, alarms: float = FALSE_ALARMS) -> float:
    """Return the significance threshold for `tests` tests, in standard deviations above chance (Bonferroni)."""
    return NormalDist().inv_cdf(1 - alarms / max(1, tests))


def thresholds(probes: Sequence[Probe]) -> list[float]:
    """Return the thresholds of a task's probes. Half of the alarms are shared evenly, half go to the weakest probes.

    The second half is distributed so that all probes detect the same smallest possible shortcut (weights by power,
    Roeder & Wasserman 2009). If none of `SHORTCUT_SIZES` is detectable, all alarms are shared evenly.
    """
    for size in np.arange(0.01, SHORTCUT_SIZES[-1] + 0.001, 0.01):
        needed = [_gained(probe, float(size)) for probe in probes]
        if sum(1 - NormalDist().cdf(beyond) for beyond in needed) <= FALSE_ALARMS / 2:
            return [min(beyond, threshold(len(probes), FALSE_ALARMS / 2)) for beyond in needed]
    return [threshold(len(probes))] * len(probes)


def learned_gains(seen: ProbeFeatures, data: ProbeDataset, chance: Array) -> tuple[float, ...]:
    """Return the gain above chance, with a power of 0.8, from a shortcut of each of the sizes."""
    random = np.random.default_rng(SEED)
    times = range(INJECTIONS[seen.model])
    return gain_quantile(
        [
            [float((cross_validated_scores(*inject_shortcut(seen, data, size, random)) - chance).mean()) for _ in times]
            for size in SHORTCUT_SIZES
        ]
    )


def gain_quantile(gained: Sequence[Sequence[float]]) -> tuple[float, ...]:
    """Return the gain for each size with a power of 0.8, from measured gains (sizes, repetitions).

    The variance is assumed equal for all sizes. The estimate is lowered by one standard error, since repetitions are
    few.
    """
    of_sizes = np.array(gained)
    means, times = of_sizes.mean(1), of_sizes.shape[1]
    spread = float(np.sqrt(((of_sizes - means[:, None]) ** 2).sum() / (of_sizes.size - len(means))))
    return tuple(float(mean) for mean in means - (NormalDist().inv_cdf(POWER) + times**-0.5) * spread)


def smallest_detectable(probe: Probe, beyond: float) -> float:
    """Return the smallest shortcut detected with a power of 0.8; 1 if none of the sizes.

    A result is significant more than `beyond` deviations above chance.
    """
    sizes = np.arange(0.0, (1.0 if probe.learned is None else SHORTCUT_SIZES[-1]) + 1e-9, 0.002)
    found = [size for size in sizes if _gained(probe, float(size)) >= beyond - 1e-9]
    return max(float(found[0]), beyond * probe.deviation) if found else 1.0


def inject_shortcut(
    seen: ProbeFeatures, data: ProbeDataset, size: float, random: np.random.Generator
) -> tuple[ProbeFeatures, ProbeDataset]:
    """Return the input with a random truth, and a shortcut injected into one feature.

    The feature indicates the truth in a share of questions that gives it an accuracy of `size` above chance.
    """
    count = data.sizes
    places = (random.random(data.count) * count).astype(np.int64)
    relabelled = data.with_labels(places)
    tells = random.random(data.count) < size / (1 - (1 / count).mean())
    claimed = np.where(tells, places, (random.random(data.count) * count).astype(np.int64))
    features = seen.features.copy()
    of_options = seen.of == "options"
    able = _unique_maxima(features, data) if of_options else _value_room(features)
    column = _shortcut_feature(features, able, random)
    if able[column] < MIN_UNIQUE_MAXIMA:  # no feature can hold a shortcut
        features[:, column] = random.random(len(features))
    if of_options:
        features[:, column] = _largest_at_claim(features[:, column], data, claimed, random)
    else:
        features[:, column] = _bands_by_name(features[:, column], data.name[data.starts + claimed], random)
    return replace(seen, features=features), relabelled


def _shortcut_feature(features: Array, able: Array, random: np.random.Generator) -> int:
    """Return a feature for a shortcut: one of the eight with the largest variance among the most able.

    `able` (0 to 1) says how well each feature can hold a shortcut.
    """
    possible = np.flatnonzero(able >= min(MIN_UNIQUE_MAXIMA, able.max()))
    widest = possible[np.argsort(-features[:, possible].std(0), kind="stable")][:8]
    return int(widest[random.integers(len(widest))])


def _value_room(features: Array) -> Array:
    """Return whether each feature has enough values for a shortcut: (d,), at most 1."""
    return np.array([min(1.0, len(np.unique(column.round(9))) / MIN_VALUES) for column in features.T])


def _unique_maxima(features: Array, data: ProbeDataset) -> Array:
    """Return the share of questions in which one option clearly has the largest value: (d,)."""
    largest = np.repeat(np.maximum.reduceat(features, data.starts), data.sizes, axis=0)
    near = features >= largest - np.maximum(MIN_LEAD * features.std(0), 1e-9)
    having = np.add.reduceat(near.astype(np.float64), data.starts)
    return np.asarray((having == 1).mean(0))


def _largest_at_claim(column: Array, data: ProbeDataset, claimed: np.ndarray, random: np.random.Generator) -> Array:
    """Return each question's values in random order, with the largest at the claimed position."""
    put = column.copy()
    for start, size, place in zip(data.starts, data.sizes, claimed, strict=True):
        values = random.permutation(column[start : start + size])
        best = int(values.argmax())
        values[[best, place]] = values[[place, best]]
        put[start : start + size] = values
    return put


def _bands_by_name(column: Array, groups: np.ndarray, random: np.random.Generator) -> Array:
    """Return the values rearranged so that each name has a range of its own."""
    order = np.argsort(np.unique(groups, return_inverse=True)[1] + random.random(len(groups)), kind="stable")
    put = np.empty_like(column)
    put[order] = np.sort(column)
    return put
