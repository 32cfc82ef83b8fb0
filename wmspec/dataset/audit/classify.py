"""Small classifiers that pick one of a question's options, judged on questions that they were not fitted to.

Linear ones for words and options, forests for pictures and what is in them, as scikit-learn has them.
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
    from sklearn.ensemble import RandomForestClassifier
    from sklearn.linear_model import RidgeCV, lasso_path
    from sklearn.model_selection import GroupKFold
except ImportError as error:
    raise WmsError("an audit needs scikit-learn", help="pip install 'wmspec[audit]'") from error

Array = NDArray[np.float64]

FOLDS = 5
#: The trees of a forest, the fewest questions (or options) in a leaf, and the share of numbers that a split may be at:
#: all, because a shortcut is apt to be in few of them.
TREES, LEAF, NUMBERS = 20, 16, 1.0
#: The trees of one that is fitted to pick a probe by.
FEW_TREES = 6
#: The ridges that are tried where numbers outnumber questions, as multiples of these; cross-validation picks one.
RIDGES = (1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0)
#: The penalties of the lasso that are tried, as shares of the one that leaves nothing.
PENALTIES = np.geomspace(1.0, 0.01, 30)
SEED = 20_611


@dataclass(frozen=True)
class Asked:
    """What is to be picked of which questions.

    For every option in order, whose it is (from 0, ascending), what it is called, and whether it is true; for every
    question, its group. Questions of one group are held out together.
    """

    owner: NDArray[np.int64]
    name: NDArray[np.str_]
    truth: NDArray[np.bool_]
    groups: Sequence[str]

    @property
    def count(self) -> int:
        """How many questions there are."""
        return len(self.groups)

    @cached_property
    def starts(self) -> NDArray[np.int64]:
        """The first option of every question."""
        return np.asarray(np.flatnonzero(np.r_[True, self.owner[1:] != self.owner[:-1]]))

    @cached_property
    def sizes(self) -> NDArray[np.int64]:
        """How many options every question has."""
        return np.asarray(np.diff(np.r_[self.starts, len(self.owner)]))

    @cached_property
    def folds(self) -> list[NDArray[np.int64]]:
        """The questions held out together; one fold alone if there are too few groups."""
        number = np.unique(self.groups, return_inverse=True)[1]
        folds = min(FOLDS, int(number.max()) + 1)
        shuffled = np.random.default_rng(SEED).permutation(int(number.max()) + 1)[number]
        splits = GroupKFold(folds).split(shuffled, groups=shuffled) if folds > 1 else ()
        return [held for _, held in splits]

    def among(self, values: Array) -> Array:
        """Values (options, d) relative to the mean of their question's options."""
        means = np.add.reduceat(values, self.starts, axis=0) / self.sizes[:, None]
        return np.asarray(values - np.repeat(means, self.sizes, axis=0))

    def ranks(self, values: Array) -> Array:
        """By each value (options, d), how many more of its question's options have a smaller one than a larger one."""
        stood = [np.sign((one[:, None] - one).round(9)).sum(1) for one in np.split(values, self.starts[1:])]
        return np.concatenate(stood)

    def retold(self, places: NDArray[np.int64]) -> Asked:
        """The same questions with other options true: of each the one at this place."""
        truth = np.zeros(len(self.owner), dtype=bool)
        truth[self.starts + places] = True
        return replace(self, truth=truth)


@dataclass(frozen=True)
class Seen:
    """What a probe sees as `features`, of every option (options, d) or of every question (questions, d).

    If `ranked`, it also sees the order of a question's options by each of the features.
    """

    features: Array
    of: Literal["options", "questions"]
    model: Literal["linear", "forest"]
    ranked: bool = False


def held_out(seen: Seen, asked: Asked) -> Array:
    """For every question, how right the classifier is that was fitted to the other folds: 1, 0, or a part at a tie.

    Seen option by option, features count relative to the mean of a question's options, so that nothing but the
    difference between options does. Seen question by question, options are told apart by their names.
    """
    scores = np.zeros(len(asked.owner))
    for held in asked.folds:
        here = np.isin(asked.owner, held)
        scores[here] = _scores(seen, asked, ~here, here, TREES)
    return hits(scores, asked)


def held_out_twice(seen: Seen, asked: Asked) -> Array:
    """The same (folds, questions) of classifiers that were fitted without a further fold, too: the row's.

    Nothing in a row was seen by what it tells of the other folds, so that it may pick what is judged on its own. There
    it is nought.
    """
    inside = [np.isin(asked.owner, held) for held in asked.folds]
    scores = np.zeros((len(inside), len(asked.owner)))
    for one, other in combinations(range(len(inside)), 2):
        either = inside[one] | inside[other]
        told = np.zeros(len(asked.owner))
        told[either] = _scores(seen, asked, ~either, either, FEW_TREES)
        scores[one, inside[other]], scores[other, inside[one]] = told[inside[other]], told[inside[one]]
    right = np.stack([hits(row, asked) for row in scores])
    for row, held in zip(right, asked.folds, strict=True):
        row[held] = 0
    return right


def hits(scores: Array, asked: Asked) -> Array:
    """1 where the true option scores highest, 1/n where n options tie with it, else 0."""
    best = np.maximum.reduceat(scores, asked.starts)
    top = scores >= best[asked.owner] - 1e-9
    ties = np.add.reduceat(top.astype(np.float64), asked.starts)
    return np.asarray(np.add.reduceat((top & asked.truth).astype(np.float64), asked.starts) / ties)


def _scores(seen: Seen, asked: Asked, fitted: NDArray[np.bool_], here: NDArray[np.bool_], trees: int) -> Array:
    """How true each option `here` seems to a classifier that was `fitted` to those."""
    return (_of_options if seen.of == "options" else _of_questions)(seen, asked, fitted, here, trees)


def _of_options(seen: Seen, asked: Asked, fitted: NDArray[np.bool_], here: NDArray[np.bool_], trees: int) -> Array:
    x = asked.among(seen.features)
    if seen.ranked:
        x = np.concatenate([x, asked.ranks(seen.features)], axis=1)
    if seen.model == "forest":
        return _probabilities(x[fitted], asked.truth[fitted], x[here], trees)[1][:, -1]
    y = asked.among(asked.truth[:, None].astype(np.float64))[:, 0]
    return _linear(x[fitted], y[fitted], x[here])


def _of_questions(seen: Seen, asked: Asked, fitted: NDArray[np.bool_], here: NDArray[np.bool_], trees: int) -> Array:
    true, held, others = asked.name[asked.truth], here[asked.starts], fitted[asked.starts]
    x = seen.features
    if seen.model == "forest":
        classes, scores = _probabilities(x[others], true[others], x[held], trees)
    else:
        classes = np.unique(true[others])
        scores = _linear(x[others], (true[others, None] == classes).astype(np.float64), x[held])
    place = np.searchsorted(classes, asked.name[here]).clip(max=len(classes) - 1)
    row = np.searchsorted(np.flatnonzero(held), asked.owner[here])
    return np.where(classes[place] == asked.name[here], scores[row, place], -1.0)


def _linear(x: Array, y: Array, unseen: Array) -> Array:
    """A regression on few of the numbers, as a shortcut is apt to be in few; on all, if there are too few questions."""
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
    """The coefficients of a lasso of what is centred, its penalty by Schwarz's criterion (Zou and others 2007).

    `noise` is the variance that a regression on all of it leaves.
    """
    most = max(float(abs(x.T @ y).max()) / len(x), 1e-12)
    paths = lasso_path(x, y, alphas=most * PENALTIES)[1]  # (d, penalties)
    left = ((y[:, None] - x @ paths) ** 2).sum(0)
    used = (abs(paths) > 1e-9).sum(0)
    return np.asarray(paths[:, (left / max(noise, 1e-12) + np.log(len(x)) * used).argmin()])


def _probabilities(x: Array, y: NDArray[np.generic], unseen: Array, trees: int) -> tuple[NDArray[np.generic], Array]:
    """The classes, and the probability of each for what was not fitted to."""
    forest = RandomForestClassifier(trees, min_samples_leaf=LEAF, max_features=NUMBERS, random_state=SEED).fit(x, y)
    return forest.classes_, np.asarray(forest.predict_proba(unseen))
