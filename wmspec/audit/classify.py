"""Small classifiers that pick one of a question's options, judged on questions that they were not fitted to.

Linear ones for words and options, forests for pictures and what is in them, as scikit-learn has them.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from wmspec.diagnostics import WmsError

try:
    from sklearn.ensemble import RandomForestClassifier
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.linear_model import LassoLarsIC, RidgeCV
    from sklearn.model_selection import GroupKFold
except ImportError as error:
    raise WmsError("an audit needs scikit-learn", help="pip install 'wmspec[audit]'") from error

Array = NDArray[np.float64]

FOLDS = 5
#: The trees of a forest, the fewest questions (or options) in a leaf, and the share of numbers that a split may be at:
#: many, because a shortcut is apt to be in few of them.
TREES, LEAF, NUMBERS = 30, 12, 0.5
#: The ridges that are tried where numbers outnumber questions, as multiples of these; cross-validation picks one.
RIDGES = (1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0)
SEED = 20_611


@dataclass(frozen=True)
class Asked:
    """What is to be picked: for every option in order, whose it is (from 0, ascending), what it is called, and whether

    it is true; for every question, its group. Questions of one group are held out together.
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

    def retold(self, places: NDArray[np.int64]) -> Asked:
        """The same questions with other options true: of each the one at this place."""
        truth = np.zeros(len(self.owner), dtype=bool)
        truth[self.starts + places] = True
        return replace(self, truth=truth)


@dataclass(frozen=True)
class Seen:
    """What a probe sees as `features`, of every option (options, d) or of every question (questions, d)."""

    features: Array
    of: Literal["options", "questions"]
    model: Literal["linear", "forest"]


def held_out(seen: Seen, asked: Asked) -> Array:
    """For every question, how right the classifier is that was fitted to the other folds: 1, 0, or a part at a tie.

    Seen option by option, features count relative to the mean of a question's options, so that nothing but the
    difference between options does. Seen question by question, options are told apart by their names.
    """
    scores = np.zeros(len(asked.owner))
    for held in asked.folds:
        here = np.isin(asked.owner, held)
        scores[here] = (_of_options if seen.of == "options" else _of_questions)(seen, asked, here)
    return hits(scores, asked)


def hits(scores: Array, asked: Asked) -> Array:
    """1 where the true option scores highest, 1/n where n options tie with it, else 0."""
    best = np.maximum.reduceat(scores, asked.starts)
    top = scores >= best[asked.owner] - 1e-9
    ties = np.add.reduceat(top.astype(np.float64), asked.starts)
    return np.asarray(np.add.reduceat((top & asked.truth).astype(np.float64), asked.starts) / ties)


def _of_options(seen: Seen, asked: Asked, here: NDArray[np.bool_]) -> Array:
    x = asked.among(seen.features)
    if seen.model == "forest":
        return _probabilities(x[~here], asked.truth[~here], x[here])[1][:, -1]
    y = asked.among(asked.truth[:, None].astype(np.float64))[:, 0]
    return _linear(x[~here], y[~here], x[here])


def _of_questions(seen: Seen, asked: Asked, here: NDArray[np.bool_]) -> Array:
    true, held = asked.name[asked.truth], here[asked.starts]
    x = seen.features
    if seen.model == "forest":
        classes, scores = _probabilities(x[~held], true[~held], x[held])
    else:
        classes = np.unique(true[~held])
        scores = _linear(x[~held], (true[~held, None] == classes).astype(np.float64), x[held])
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
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # of numbers that say the same, all but one are dropped
        each = [LassoLarsIC("bic").fit(x, column).predict(unseen) for column in y.reshape(len(y), -1).T]
    return np.stack(each, axis=-1).reshape(len(unseen), *y.shape[1:])


def _probabilities(x: Array, y: NDArray[np.generic], unseen: Array) -> tuple[NDArray[np.generic], Array]:
    """The classes, and the probability of each for what was not fitted to."""
    forest = RandomForestClassifier(TREES, min_samples_leaf=LEAF, max_features=NUMBERS, random_state=SEED).fit(x, y)
    return forest.classes_, np.asarray(forest.predict_proba(unseen))
