"""A small linear classifier that picks one of a question's options, judged on questions that it was not fitted to."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FOLDS = 5
#: Features are compressed to so many principal directions before anything is fitted.
MOST_FEATURES = 200
#: The ridges that are tried, as multiples of the number of options fitted to; generalised cross-validation picks one.
RIDGES = (1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0)


def held_out(features: Array, owner: NDArray[np.int64], truth: NDArray[np.bool_], groups: Sequence[str]) -> Array:
    """For every question, how right the classifier is that was fitted to the other folds: 1, 0, or a part at a tie.

    `features` (options, d) describe the options of all questions, `owner` says whose option each is, `truth` whether
    it is the true one. `groups` has a key for every question: questions of one group are held out together.

    Features and truth are taken relative to the mean of a question's options, so nothing but the difference between
    options counts; a ridge regression of truth on features then scores them, and the highest score is the choice.
    """
    x, y = _within(features, owner), _within(truth[:, None].astype(np.float64), owner)[:, 0]
    x = _compressed(x)
    fold = np.array([_fold(g) for g in groups])[owner]
    scores = np.zeros(len(x))
    for k in range(FOLDS):
        here = fold == k
        if here.any() and not here.all():
            scores[here] = x[here] @ _ridge(x[~here], y[~here])
    return _hits(scores, owner, truth, len(groups))


def _fold(group: str) -> int:
    return int.from_bytes(hashlib.sha256(group.encode()).digest()[:8], "big") % FOLDS


def _within(values: Array, owner: NDArray[np.int64]) -> Array:
    """Values (options, d) relative to the mean of their question's options. `owner` is in ascending order."""
    starts = np.flatnonzero(np.r_[True, owner[1:] != owner[:-1]])
    sizes = np.diff(np.r_[starts, len(owner)])
    means = np.add.reduceat(values, starts, axis=0) / sizes[:, None]
    return np.asarray(values - np.repeat(means, sizes, axis=0))


def _compressed(x: Array) -> Array:
    """Features of equal spread, as their principal components if there are many."""
    spread = x.std(0)
    x = x[:, spread > 1e-9] / spread[spread > 1e-9]
    if x.shape[1] <= MOST_FEATURES:
        return x
    _, directions = np.linalg.eigh(x.T @ x)
    return np.asarray(x @ directions[:, -MOST_FEATURES:])


def _ridge(x: Array, y: Array) -> Array:
    """The weights of the ridge whose error by generalised cross-validation (Golub, Heath & Wahba 1979) is the least."""
    values, directions = np.linalg.eigh(x.T @ x)
    values, along = np.maximum(values, 0), directions.T @ (x.T @ y)
    best, least = np.zeros(x.shape[1]), np.inf
    for ridge in (r * len(x) for r in RIDGES):
        weights = along / (values + ridge)
        error = y @ y - 2 * weights @ along + weights @ (values * weights)
        freedom = len(x) - (values / (values + ridge)).sum()
        if freedom > 0 and error / freedom**2 < least:
            best, least = directions @ weights, error / freedom**2
    return best


def _hits(scores: Array, owner: NDArray[np.int64], truth: NDArray[np.bool_], count: int) -> Array:
    """1 where the true option scores highest, 1/n where n options tie with it, else 0."""
    best = np.full(count, -np.inf)
    np.maximum.at(best, owner, scores)
    top = scores >= best[owner] - 1e-9
    ties = np.bincount(owner[top], minlength=count)
    return np.bincount(owner[top & truth], minlength=count) / ties
