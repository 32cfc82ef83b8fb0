"""Item analysis: difficulty of questions, suspect labels, and a short form of the dataset.

Difficulty is fitted by a two-parameter item-response model with guessing, c + (1 − c) σ(a (θ − b)), by its maximum a
posteriori with scipy (θ ~ N(0, 1), b ~ N(0, 2), log a ~ N(0, 0.5)). With few systems, θ and b are identifiable, a is
not and therefore not reported. The short form is a stratified sample: questions are ordered by task and difficulty and
cut into strata of equal weight, and the middle one of each is taken.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from wmspec.eval.report.compare import weights_in_average
from wmspec.eval.report.intervals import Floats, seeded_generator
from wmspec.eval.report.replies import BASELINES, PEOPLE, Replies

#: Minimum number of systems for a fit; maximum number of suspects; candidate sizes of the short form.
MIN_SYSTEMS, MAX_SUSPECTS, FORM_SIZES = 5, 30, (10, 20, 50, 100, 200, 500)
#: Maximum error of the short form's score (root mean square).
TOLERANCE = 0.025
#: Number of random short forms for the error estimate.
FORM_DRAWS = 50


@dataclass(frozen=True)
class Item:
    """A question: its difficulty b (in standard deviations of ability), and its accuracy over systems.

    `rest` is the item-rest correlation (None if all or no answers are right).
    """

    id: str
    task: str
    text: str
    difficulty: float
    accuracy: float
    rest: float | None


@dataclass(frozen=True)
class Ability:
    """A system's ability θ, in standard deviations."""

    system: str
    ability: float


@dataclass(frozen=True)
class Form:
    """A short form of `size` questions.

    `error` is the difference between its score and the whole one (root mean square over draws and systems, each
    excluded from the difficulty estimate). `at_random` is that of random questions.
    """

    size: int
    error: float
    at_random: float


@dataclass(frozen=True)
class Items:
    """The item analysis, over the questions that all systems answered.

    `short` has the ids of the short form, each with its weight.
    """

    items: tuple[Item, ...]
    abilities: tuple[Ability, ...]
    forms: tuple[Form, ...]
    short: tuple[tuple[str, int], ...]

    @property
    def suspects(self) -> tuple[Item, ...]:
        """Items that better systems get wrong more often, worst first: their labels deserve a check."""
        negative = [item for item in self.items if item.rest is not None and item.rest < 0]
        return tuple(sorted(negative, key=lambda item: (item.rest, item.id))[:MAX_SUSPECTS])


def items(replies: Replies) -> Items | None:
    """Return the analysis; None if fewer than LEAST_SYSTEMS systems, except baselines, answered the same questions."""
    systems = [s for s in replies.systems if s not in BASELINES and s != PEOPLE]
    scores = replies.scores.loc[replies.main_questions.index, systems]
    scores = scores.loc[:, scores.notna().mean() > 0.5].dropna() if systems else scores
    if scores.shape[1] < MIN_SYSTEMS or len(scores) < 2:
        return None
    about = replies.main_questions.loc[scores.index]
    answers = scores.to_numpy()
    options = about["options"].to_numpy(dtype=float)
    guess = np.where(options > 0, 1 / np.maximum(options, 1), 0.0)
    ability, difficulty = fit_item_response(answers, guess)
    rest = item_rest_correlation(answers)
    text = replies.questions.table["text"] if replies.questions else pd.Series("", scores.index)
    made = tuple(
        Item(
            str(name),
            str(about.at[name, "task"]),
            str(text[name]),
            float(b),
            float(p),
            None if np.isnan(r) else float(r),
        )
        for name, b, p, r in zip(scores.index, difficulty, answers.mean(1), rest, strict=True)
    )
    forms, short = _short(answers, weights_in_average(about, by_kind=True), about["task"].to_numpy(dtype=str))
    return Items(
        made,
        tuple(Ability(s, float(a)) for s, a in zip(scores.columns, ability, strict=True)),
        forms,
        tuple((str(scores.index[i]), int(n)) for i, n in zip(*np.unique(short, return_counts=True), strict=True)),
    )


# ---------------------------------------------------------------- item response


def fit_item_response(answers: Floats, guess: Floats) -> tuple[Floats, Floats]:
    """Return ability (m,) and difficulty (n,) from answers (n, m) and the chance of guessing each item (n,).

    Items with equal answers and chance have equal difficulty, so each kind is fitted once.
    """
    from scipy.optimize import minimize

    kinds, which, count = np.unique(np.column_stack([answers, guess]), axis=0, return_inverse=True, return_counts=True)
    y, c, weight = kinds[:, :-1], kinds[:, -1:], count[:, None].astype(float)
    start = np.concatenate([_standardize(answers.mean(0)), np.zeros(2 * len(kinds))])
    solution = minimize(
        _negative_log_posterior, start, (y, c, weight), "L-BFGS-B", jac=True, options={"maxiter": 200, "maxcor": 20}
    )
    systems = answers.shape[1]
    return solution.x[:systems], solution.x[systems : systems + len(kinds)][which.ravel()]


def _standardize(share: Floats) -> Floats:
    from scipy.special import logit

    ability = logit(np.clip(share, 0.01, 0.99))
    return np.asarray((ability - ability.mean()) / max(float(ability.std()), 1e-6))


def _negative_log_posterior(q: Floats, y: Floats, c: Floats, weight: Floats) -> tuple[float, Floats]:
    """Return the negative log posterior of θ (m), b (k), log a (k), and its gradient.

    `y` is (k, m), `c` and `weight` (k, 1).
    """
    from scipy.special import expit

    kinds, systems = y.shape
    theta, b, log_a = np.split(q, [systems, systems + kinds])
    a = np.exp(log_a)[:, None]
    z = a * (theta - b[:, None])
    s = expit(z)
    p = np.clip(c + (1 - c) * s, 1e-9, 1 - 1e-9)
    likely = (weight * (y * np.log(p) + (1 - y) * np.log1p(-p))).sum()
    prior = theta @ theta / 2 + (weight[:, 0] * (b**2 / 8 + log_a**2 / 0.5)).sum()
    dz = weight * (y - p) / (p * (1 - p)) * (1 - c) * s * (1 - s)
    slope = np.concatenate([
        (dz * a).sum(0) - theta,
        -(dz * a).sum(1) - weight[:, 0] * b / 4,
        (dz * z).sum(1) - weight[:, 0] * log_a / 0.25,
    ])  # fmt: skip
    return float(prior - likely), -slope


def item_rest_correlation(answers: Floats) -> Floats:
    """Return the correlation (n,) of every item's answers (n, m) with the sums of the others, NaN if undefined."""
    rest = answers.sum(0) - answers
    x, y = (v - v.mean(1, keepdims=True) for v in (answers, rest))
    below = np.sqrt((x**2).sum(1) * (y**2).sum(1))
    return np.asarray(np.divide((x * y).sum(1), below, out=np.full(len(answers), np.nan), where=below > 1e-12))


# ---------------------------------------------------------------- short form


def _short(answers: Floats, weights: Floats, task: NDArray[np.str_]) -> tuple[tuple[Form, ...], NDArray[np.intp]]:
    """Return the errors of short forms, and the items of the smallest within tolerance, or of the largest."""
    whole = weights @ answers
    order = [np.lexsort((-np.delete(answers, j, axis=1).mean(1), task)) for j in range(answers.shape[1])]
    forms = []
    for size in (s for s in FORM_SIZES if s < len(answers) / 2):
        random = seeded_generator("short form", size, len(answers))
        missed = [
            answers[stratified_sample(order[j], weights, size, random.random(size)), j].mean() - whole[j]
            for j in range(answers.shape[1])
            for _ in range(FORM_DRAWS)
        ]
        drawn = answers[random.choice(len(answers), (FORM_DRAWS, size), p=weights)].mean(1) - whole
        forms.append(Form(size, _rms(np.array(missed)), _rms(drawn)))
    if not forms:
        return (), np.empty(0, np.intp)
    size = next((f.size for f in forms if f.error <= TOLERANCE), forms[-1].size)
    return tuple(forms), stratified_sample(np.lexsort((-answers.mean(1), task)), weights, size, np.full(size, 0.5))


def _rms(gaps: Floats) -> float:
    return float(np.sqrt(np.mean(gaps**2)))


def stratified_sample(order: NDArray[np.intp], weights: Floats, size: int, where: Floats) -> NDArray[np.intp]:
    """Return one item from each of `size` strata of equal weight: the one at fraction `where` of the stratum."""
    reached = np.cumsum(weights[order])
    targets = (np.arange(size) + where) / size * reached[-1]
    return np.asarray(order[np.minimum(np.searchsorted(reached, targets), len(order) - 1)])
