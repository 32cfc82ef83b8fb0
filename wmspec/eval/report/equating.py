"""Equating: scores on a fresh set of questions, as they would be on an earlier set of the same design.

Models that answered both sets link them. In each task, a reply is right with probability c + (1 - c) σ(θ - b), where c
is the chance of guessing, θ the ability of the model, and b the difficulty of the question. Difficulties are draws from
N(0, s²) in the earlier set and from N(δ, s²) in the fresh one. θ, δ and s maximize the likelihood of both sets
together, with difficulties integrated out (Gauss-Hermite), so that few models do not bias them. The equated score is
the expected share of right replies in the earlier set. Intervals come from a bootstrap over the control groups of both
sets, with one Newton step for each draw.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from wmspec.core.diagnostics import WmsError
from wmspec.eval.report.compare import weights_in_average
from wmspec.eval.report.intervals import DRAWS, Estimate, Floats, estimate, seeded_generator
from wmspec.eval.report.replies import Replies

#: Minimum number of models that link two sets.
MIN_LINKS = 2
#: Standard errors above guessing up to which a score is near chance.
CHANCE_ERRORS = 2.0
#: Number of nodes of the quadrature, and standard deviations of the weak priors of θ and δ, and of log s.
NODES, PRIOR, SPREAD_PRIOR = 21, 3.0, 1.0


@dataclass(frozen=True)
class EquatedScore:
    """A model's average in the fresh set, and what it would be in the earlier set.

    `earlier` is its average there if it answered that set, and thus links the two. `is_near_chance`: the fresh average
    is at most `CHANCE_ERRORS` standard errors above guessing. The model of replies has no score below guessing, so that
    the equated score is then too high, and its interval too narrow.
    """

    model: str
    fresh: float
    equated: Estimate
    earlier: float | None
    is_near_chance: bool


@dataclass(frozen=True)
class Equating:
    """The equated scores of one kind of task ('' for all), the best first.

    `shift` is how much lower the linking models score in the fresh set, by the fitted difficulties.
    """

    kind: str
    scores: tuple[EquatedScore, ...]
    shift: Estimate


def equate(fresh: Replies, earlier: Replies) -> tuple[Equating, ...]:
    """Return the equated scores over all tasks that both sets have, and for each kind of task.

    Raises WmsError if fewer than two models answered both sets, or no task is in both.
    """
    models = list(fresh.models)
    links = [model for model in models if model in earlier.models]
    if len(links) < MIN_LINKS:
        raise WmsError(
            f"--equate: {len(links)} models answered both sets, and at least {MIN_LINKS} must link them",
            help="evaluate the same versions of two models on both sets",
        )
    sets = [_Answers(replies, models) for replies in (earlier, fresh)]
    tasks = sorted(set(sets[0].about["task"]) & set(sets[1].about["task"]))
    if not tasks:
        raise WmsError("--equate: the two sets have no task in common")
    fits = {task: _fit_task(task, sets, models) for task in tasks}
    kinds = {task: str(sets[0].about.loc[sets[0].about["task"] == task, "dimension"].iloc[0]) for task in tasks}
    of_kind = {task: dimension.split(".")[0] for task, dimension in kinds.items()}
    both = sorted(set(of_kind.values()))
    chosen = ["", *(both if len(both) > 1 else ())]
    return tuple(
        _equating(kind, [t for t in tasks if kind in ("", of_kind[t])], sets, fits, (models, links)) for kind in chosen
    )


class _Answers:
    """The scores of a set: questions by models, NaN for none, with the attributes of the questions."""

    def __init__(self, replies: Replies, models: list[str]) -> None:
        about = replies.main_questions
        scores = replies.scores.reindex(columns=models).loc[about.index]
        answered = scores.notna().any(axis=1)
        self.about = about[answered]
        self.scores = scores[answered]

    def of(self, task: str) -> tuple[Floats, Floats, NDArray[np.intp]]:
        """Return the scores (n, m), chances (n,) and clusters (n,) of a task's questions."""
        rows = self.about[self.about["task"] == task]
        chance = np.clip(rows["chance"].fillna(0.0).to_numpy(dtype=float), 0.0, 0.95)
        _, clusters = np.unique(rows["cluster"].to_numpy(dtype=str), return_inverse=True)
        return self.scores.loc[rows.index].to_numpy(dtype=float), chance, clusters


@dataclass(frozen=True)
class _Fit:
    """Expected scores (m,) of the models in both sets, draws of both (d, m), and the number of clusters and questions.

    Models without an answer in the task have NaN.
    """

    earlier: Floats
    fresh: Floats
    earlier_drawn: Floats
    fresh_drawn: Floats
    clusters: int
    questions: int


def _fit_task(task: str, sets: list[_Answers], models: list[str]) -> _Fit:
    (y0, c0, g0), (y1, c1, g1) = (answers.of(task) for answers in sets)
    y, c = np.concatenate([y0, y1]), np.concatenate([c0, c1])
    fresh = np.repeat([0.0, 1.0], [len(y0), len(y1)])
    parameters, hessian, slopes = fit(y, c, fresh)
    count = g0.max() + 1
    clusters = np.concatenate([g0, count + g1])
    of_cluster = np.zeros((clusters.max() + 1, slopes.shape[1]))
    np.add.at(of_cluster, clusters, slopes)
    random = seeded_generator("equating", task, len(y), len(models))
    both = (of_cluster[:count], of_cluster[count:])
    moved = sum(
        (random.multinomial(len(part), np.full(len(part), 1 / len(part)), size=DRAWS) - 1.0) @ part for part in both
    )
    drawn = parameters + np.linalg.solve(hessian, np.asarray(moved).T).T
    answered = ~np.isnan(y).all(0)
    means = [expected(parameters[None], c0, shifted)[0] for shifted in (False, True)]
    spreads = [expected(drawn, c0, shifted) for shifted in (False, True)]
    for each in (*means, *spreads):
        each[..., ~answered] = np.nan
    return _Fit(means[0], means[1], spreads[0], spreads[1], min(map(len, both)), len(y))


def _equating(
    kind: str, tasks: list[str], sets: list[_Answers], fits: dict[str, _Fit], named: tuple[list[str], list[str]]
) -> Equating:
    models, links = named
    weights = [_task_weights(answers, tasks) for answers in sets]
    means = [_averages(answers, tasks, weights[0]) for answers in sets]
    value = sum(weights[0][task] * fits[task].earlier for task in tasks)
    drawn = sum(weights[0][task] * fits[task].earlier_drawn for task in tasks)
    lost = sum(weights[0][task] * (fits[task].earlier - fits[task].fresh) for task in tasks)
    lost_drawn = sum(weights[0][task] * (fits[task].earlier_drawn - fits[task].fresh_drawn) for task in tasks)
    questions, clusters = sum(fits[t].questions for t in tasks), min(fits[t].clusters for t in tasks)
    linked = [models.index(link) for link in links]
    shift = estimate(
        float(np.mean(np.asarray(lost)[linked])), np.asarray(lost_drawn)[:, linked].mean(1), questions, clusters
    )
    near_chance = _near_chance(sets[1], tasks, weights[1])
    scores = [
        EquatedScore(
            model,
            float(means[1][j]),
            estimate(float(np.asarray(value)[j]), np.asarray(drawn)[:, j], questions, clusters),
            float(means[0][j]) if model in links else None,
            bool(means[1][j] <= near_chance),
        )
        for j, model in enumerate(models)
        if not np.isnan(np.asarray(value)[j])
    ]
    return Equating(kind, tuple(sorted(scores, key=lambda s: (-s.equated.value, s.model))), shift)


def _near_chance(answers: _Answers, tasks: list[str], weights: dict[str, float]) -> float:
    """Return the highest average that is near chance."""
    chance, variance = 0.0, 0.0
    for task in tasks:
        _, guesses, _ = answers.of(task)
        chance += weights[task] * float(guesses.mean())
        variance += weights[task] ** 2 * float((guesses * (1 - guesses)).mean()) / len(guesses)
    return chance + CHANCE_ERRORS * float(np.sqrt(variance))


def _task_weights(answers: _Answers, tasks: list[str]) -> dict[str, float]:
    """Return the weight of each task in the average over dimensions."""
    about = answers.about[answers.about["task"].isin(tasks)]
    weights = pd.Series(weights_in_average(about), about.index).groupby(about["task"]).sum()
    return {str(task): float(weight) for task, weight in weights.items()}


def _averages(answers: _Answers, tasks: list[str], weights: dict[str, float]) -> Floats:
    """Return the averages (m,) of the models' raw scores."""
    total = np.zeros(answers.scores.shape[1])
    for task in tasks:
        total += weights[task] * answers.scores[answers.about["task"] == task].mean().to_numpy(dtype=float)
    return total


# ---------------------------------------------------------------- the model

_POINTS, _WEIGHTS = np.polynomial.hermite_e.hermegauss(NODES)
_LOG_WEIGHTS = np.log(_WEIGHTS / _WEIGHTS.sum())


def fit(y: Floats, c: Floats, fresh: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the parameters (m + 2,), the Hessian there, and the slope of each question's likelihood (n, m + 2).

    `y` (n, m) are shares of right replies, NaN for none; `c` (n,) is the chance of guessing; `fresh` (n,) is 1 for
    questions of the fresh set. The parameters are θ of each model, δ, and log s.
    """
    from scipy.optimize import minimize

    guess, right = float(np.mean(c)), np.clip(np.nan_to_num(np.nanmean(y, axis=0), nan=0.5), 0.02, 0.98)
    share = np.clip((right - guess) / (1 - guess), 0.02, 0.98)
    start = np.concatenate([np.log(share / (1 - share)), [0.0, 0.0]])

    def objective(q: Floats) -> tuple[float, Floats]:
        value, slopes = _likelihood(q, y, c, fresh)
        prior, prior_slope = _prior(q)
        return prior - value, prior_slope - slopes.sum(0)

    found = minimize(objective, start, jac=True, method="L-BFGS-B", options={"maxiter": 500, "ftol": 1e-12})
    step = 1e-4
    hessian = np.array([
        (objective(found.x + step * unit)[1] - objective(found.x - step * unit)[1]) / (2 * step)
        for unit in np.eye(len(found.x))
    ])  # fmt: skip
    return found.x, (hessian + hessian.T) / 2, _likelihood(found.x, y, c, fresh)[1]


def _prior(q: Floats) -> tuple[float, Floats]:
    scale = np.append(np.full(len(q) - 1, PRIOR), SPREAD_PRIOR)
    return float((q**2 / scale**2).sum() / 2), q / scale**2


def _likelihood(q: Floats, y: Floats, c: Floats, fresh: Floats) -> tuple[float, Floats]:
    """Return the log-likelihood, and its gradient for each question (n, m + 2)."""
    from scipy.special import expit, logsumexp

    theta, delta, spread = q[:-2], q[-2], np.exp(q[-1])
    observed = ~np.isnan(y)
    known = np.where(observed, y, 0.0)[:, None]  # (n, 1, m)
    difficulty = fresh[:, None] * delta + spread * _POINTS  # (n, q)
    s = expit(theta - difficulty[..., None])  # (n, q, m)
    guess = c[:, None, None]
    p = np.clip(guess + (1 - guess) * s, 1e-9, 1 - 1e-9)
    terms = np.where(observed[:, None], known * np.log(p) + (1 - known) * np.log1p(-p), 0.0)
    joint = terms.sum(-1) + _LOG_WEIGHTS
    whole = logsumexp(joint, axis=1)
    posterior = np.exp(joint - whole[:, None])
    dz = np.where(observed[:, None], (known - p) / (p * (1 - p)) * (1 - guess) * s * (1 - s), 0.0)
    of_theta = (posterior[..., None] * dz).sum(1)
    of_difficulty = -posterior * dz.sum(-1)
    slopes = np.column_stack([
        of_theta, of_difficulty.sum(1) * fresh, (of_difficulty * _POINTS).sum(1) * spread,
    ])  # fmt: skip
    return float(whole.sum()), slopes


def expected(parameters: Floats, c: Floats, shifted: bool) -> Floats:
    """Return the expected scores (d, m) of models with `parameters` (d, m + 2), `shifted`: in the fresh set."""
    from scipy.special import expit

    theta, delta, spread = parameters[:, :-2], parameters[:, -2], np.exp(np.clip(parameters[:, -1], -20, 5))
    places = (delta[:, None] if shifted else 0.0) + spread[:, None] * _POINTS  # (d, q)
    able = np.zeros_like(theta)
    for number, weight in enumerate(np.exp(_LOG_WEIGHTS)):
        able += weight * expit(theta - places[:, number, None])
    guess = float(np.mean(c))
    return np.asarray(guess + (1 - guess) * able)
