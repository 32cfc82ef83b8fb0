"""Cross-validated classifiers that choose one of a question's options.

Linear models for words and options, random forests for pictures and object states, from scikit-learn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from wmspec.core.diagnostics import WmsError

try:
    from sklearn import config_context
    from sklearn.linear_model import RidgeCV, lasso_path
    from sklearn.model_selection import GroupKFold
    from sklearn.tree import DecisionTreeClassifier
except ImportError as error:
    raise WmsError("an audit needs scikit-learn", help="pip install 'wmspec[audit]'") from error

Array = NDArray[np.float64]

FOLDS = 5
#: Trees of a forest, minimum samples in a leaf, share of features tried at a split. All features are tried, because
#: shortcuts tend to be in few of them.
FOREST_TREES, MIN_LEAF, FEATURE_SHARE = 20, 16, 1.0
#: Trees of a forest fitted for selecting a probe.
SELECTION_TREES = 6
#: Ridge penalties for cases with more features than questions; cross-validation chooses one.
RIDGES = (1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0)
#: Lasso penalties, relative to the one that removes all features.
PENALTIES = np.geomspace(1.0, 0.01, 30)
SEED = 20_611


@dataclass(frozen=True)
class ProbeDataset:
    """The options of questions as a classification problem.

    For every option in order: `owner`, the index of its question (ascending from 0), its `name`, and its `truth`. For
    every question: its group. Questions of one group are held out together.
    """

    owner: NDArray[np.int64]
    name: NDArray[np.str_]
    truth: NDArray[np.bool_]
    groups: Sequence[str]

    @property
    def count(self) -> int:
        """The number of questions."""
        return len(self.groups)

    @cached_property
    def starts(self) -> NDArray[np.int64]:
        """The index of every question's first option."""
        return np.asarray(np.flatnonzero(np.r_[True, self.owner[1:] != self.owner[:-1]]))

    @cached_property
    def sizes(self) -> NDArray[np.int64]:
        """The number of options of every question."""
        return np.asarray(np.diff(np.r_[self.starts, len(self.owner)]))

    @cached_property
    def folds(self) -> list[NDArray[np.int64]]:
        """The questions held out together; a single fold if there are too few groups."""
        number = np.unique(self.groups, return_inverse=True)[1]
        folds = min(FOLDS, int(number.max()) + 1)
        shuffled = np.random.default_rng(SEED).permutation(int(number.max()) + 1)[number]
        splits = GroupKFold(folds).split(shuffled, groups=shuffled) if folds > 1 else ()
        return [held for _, held in splits]

    def centred(self, values: Array) -> Array:
        """Return values (options, d) relative to the mean of their question's options."""
        means = np.add.reduceat(values, self.starts, axis=0) / self.sizes[:, None]
        return np.asarray(values - np.repeat(means, self.sizes, axis=0))

    def ranks(self, values: Array) -> Array:
        """Return each value's rank (options, d): smaller minus larger values among the question's options."""
        stood = [np.sign((one[:, None] - one).round(9)).sum(1) for one in np.split(values, self.starts[1:])]
        return np.concatenate(stood)

    def with_labels(self, places: NDArray[np.int64]) -> ProbeDataset:
        """Return the same questions with other true options: in each question, the one at the given position."""
        truth = np.zeros(len(self.owner), dtype=bool)
        truth[self.starts + places] = True
        return replace(self, truth=truth)


@dataclass(frozen=True)
class ProbeFeatures:
    """The input of a probe: `features` of every option (options, d) or of every question (questions, d).

    If `ranked`, the ranks of the features among a question's options are inputs as well.
    """

    features: Array
    of: Literal["options", "questions"]
    model: Literal["linear", "forest"]
    ranked: bool = False


def cross_validated_scores(seen: ProbeFeatures, data: ProbeDataset) -> Array:
    """Return the score of every question by a classifier fitted to the other folds: 1, 0, or a fraction at a tie.

    Features of options are taken relative to the mean of a question's options, so that only differences between options
    count. Features of questions distinguish options by their names.
    """
    scores = np.zeros(len(data.owner))
    for held in data.folds:
        here = np.isin(data.owner, held)
        scores[here] = _scores(seen, data, ~here, here, FOREST_TREES)
    return top1_score(scores, data)


def nested_scores(seen: ProbeFeatures, data: ProbeDataset) -> Array:
    """Return scores (folds, questions) of classifiers fitted without the row's fold and the question's fold.

    A row is independent of its own fold. It can therefore select a probe that is then judged on that fold. Scores of
    the row's own fold are 0.
    """
    inside = [np.isin(data.owner, held) for held in data.folds]
    scores = np.zeros((len(inside), len(data.owner)))
    for one, other in combinations(range(len(inside)), 2):
        either = inside[one] | inside[other]
        scored = np.zeros(len(data.owner))
        scored[either] = _scores(seen, data, ~either, either, SELECTION_TREES)
        scores[one, inside[other]], scores[other, inside[one]] = scored[inside[other]], scored[inside[one]]
    right = np.stack([top1_score(row, data) for row in scores])
    for row, held in zip(right, data.folds, strict=True):
        row[held] = 0
    return right


def top1_score(scores: Array, data: ProbeDataset) -> Array:
    """Return 1 where the true option scores highest, 1/n where n options tie with it, else 0."""
    best = np.maximum.reduceat(scores, data.starts)
    top = scores >= best[data.owner] - 1e-9
    ties = np.add.reduceat(top.astype(np.float64), data.starts)
    return np.asarray(np.add.reduceat((top & data.truth).astype(np.float64), data.starts) / ties)


def _scores(
    seen: ProbeFeatures, data: ProbeDataset, fitted: NDArray[np.bool_], here: NDArray[np.bool_], trees: int
) -> Array:
    """Return the score of every option in `here` by a classifier fitted to `fitted`."""
    return (_of_options if seen.of == "options" else _of_questions)(seen, data, fitted, here, trees)


def _of_options(
    seen: ProbeFeatures, data: ProbeDataset, fitted: NDArray[np.bool_], here: NDArray[np.bool_], trees: int
) -> Array:
    x = data.centred(seen.features)
    if seen.ranked:
        x = np.concatenate([x, data.ranks(seen.features)], axis=1)
    if seen.model == "forest":
        return _probabilities(x[fitted], data.truth[fitted], x[here], trees)[1][:, -1]
    y = data.centred(data.truth[:, None].astype(np.float64))[:, 0]
    return _linear(x[fitted], y[fitted], x[here])


def _of_questions(
    seen: ProbeFeatures, data: ProbeDataset, fitted: NDArray[np.bool_], here: NDArray[np.bool_], trees: int
) -> Array:
    true, held, others = data.name[data.truth], here[data.starts], fitted[data.starts]
    x = seen.features
    if seen.model == "forest":
        classes, scores = _probabilities(x[others], true[others], x[held], trees)
    else:
        classes = np.unique(true[others])
        scores = _linear(x[others], (true[others, None] == classes).astype(np.float64), x[held])
    place = np.searchsorted(classes, data.name[here]).clip(max=len(classes) - 1)
    row = np.searchsorted(np.flatnonzero(held), data.owner[here])
    return np.where(classes[place] == data.name[here], scores[row, place], -1.0)


def _linear(x: Array, y: Array, unseen: Array) -> Array:
    """Return predictions of a sparse regression, since shortcuts tend to be in few features.

    The regression is dense if there are too few questions.
    """
    middle, spread = x.mean(0), x.std(0)
    spread[spread < 1e-9] = np.inf
    x, unseen = (x - middle) / spread, (unseen - middle) / spread
    if len(x) <= x.shape[1] + 1:
        return np.asarray(RidgeCV(alphas=[r * len(x) for r in RIDGES]).fit(x, y).predict(unseen))
    columns = (y - y.mean(0)).reshape(len(y), -1)
    solved, _, rank, _ = np.linalg.lstsq(x, columns, rcond=None)
    noise = ((columns - x @ solved) ** 2).sum(0) / (len(x) - rank)
    each = [_lasso(x, *both) for both in zip(columns.T, noise, strict=True)]
    return np.asarray(y.mean(0) + (unseen @ np.stack(each, axis=-1)).reshape(len(unseen), *y.shape[1:]))


def _lasso(x: Array, y: Array, noise: float) -> Array:
    """Return the coefficients of a lasso on centred data, with the penalty of the Bayesian criterion (Zou et al. 2007).

    `noise` is the residual variance of the full regression. The path is that of `lasso_path`, to the bit, without the
    checks that it repeats for every penalty: they take four times as long.
    """
    most = max(float(abs(x.T @ y).max()) / len(x), 1e-12)
    with config_context(skip_parameter_validation=True):
        paths = lasso_path(np.asfortranarray(x), y, alphas=most * PENALTIES, check_input=False)[1]  # (d, penalties)
    left = ((y[:, None] - x @ paths) ** 2).sum(0)
    used = (abs(paths) > 1e-9).sum(0)
    return np.asarray(paths[:, (left / max(noise, 1e-12) + np.log(len(x)) * used).argmin()])


def _probabilities(x: Array, y: NDArray[np.generic], unseen: Array, trees: int) -> tuple[NDArray[np.generic], Array]:
    """Return the classes, and their probabilities for unseen samples.

    The forest is a `RandomForestClassifier`, to the bit, without the checks that it repeats for every tree: they take
    longer than small trees.
    """
    classes, numbers = np.unique(y, return_inverse=True)
    x, unseen = np.ascontiguousarray(x, np.float32), np.ascontiguousarray(unseen, np.float32)
    sums, seeds = np.zeros((len(unseen), len(classes))), np.random.RandomState(SEED)
    with config_context(assume_finite=True, skip_parameter_validation=True):
        for _ in range(trees):
            seed = seeds.randint(np.iinfo(np.int32).max)
            drawn = np.random.RandomState(seed).randint(0, len(x), len(x), dtype=np.int32)
            tree = DecisionTreeClassifier(min_samples_leaf=MIN_LEAF, max_features=FEATURE_SHARE, random_state=seed)
            tree.fit(x, numbers, np.bincount(drawn, minlength=len(x)), check_input=False)
            sums += tree.predict_proba(unseen, check_input=False)
    return classes, sums / trees
