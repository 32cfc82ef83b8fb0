"""Probes of a known factor together with a cheap rule that chooses among the options that the factor leaves.

In a closed set of pictures, to know one varied factor (from the text, or from the pictures) leaves the options with its
level, usually two. The factor alone must leave it there. So must each rule of thumb, such as likeness to the last
picture. A rule is applied in two ways: to the options left, and to the levels of the other factors, each scored by its
best option of all. The second finds the picture that shows how something moves, although its outcome is another's.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from wmspec.dataset.audit import state
from wmspec.dataset.audit.cases import Case, Unit
from wmspec.dataset.audit.classify import Array, ProbeFeatures
from wmspec.dataset.audit.duplicates import pixel_difference
from wmspec.dataset.audit.given import ClosedSet, closed_set, given_in_words, varied_factors
from wmspec.dataset.audit.image_similarity import from_others
from wmspec.dataset.audit.model import Probe
from wmspec.dataset.audit.probed import Look, ProbedQuestions, ProbeSpec
from wmspec.dataset.build.rows import Row

_ALONE = "it leaves several options"
_RIVAL = "only the best of these rules is judged"
_WHY = "no rule of thumb may decide between the options that the factor leaves"
_SHOWN = "the pictures show what these options differ in"


def probes(unit: Unit, cases: Sequence[Case], groups: Sequence[str], moments: int) -> list[Probe]:
    """Return the probes of each varied factor alone, and with each rule; the best rule is judged.

    `moments` is how many moments the answer requires. Empty unless the questions have closed sets of several factors.
    """
    varied = varied_factors(cases)
    sets = [made for made in map(closed_set, cases) if made]
    made: list[Probe] = []
    for known in varied if len(varied) > 1 else ():
        made += _with_known(unit, cases, groups, sets, known, moments)
    return made


def _with_known(
    unit: Unit, cases: Sequence[Case], groups: Sequence[str], sets: Sequence[ClosedSet], known: str, moments: int
) -> list[Probe]:
    """Return the probes if the level of one factor is known."""
    struck = [~np.array(one.left(known, case.row["answer"])) for one, case in zip(sets, cases, strict=True)]
    if all(gone.sum() == gone.size - 1 for gone in struck):
        return []  # this factor is all that the options vary
    task = ProbedQuestions.of(unit.name, cases, groups, struck)
    alone = ProbeSpec(f"`{known}`", "combination", True, _ALONE, _look(task, _alone(cases, sets, known)))
    hidden = _is_hidden(unit, sets[0], known, cases, moments)
    judged, shown = list[ProbeSpec](), list[ProbeSpec]()
    for rule, scores, pictured in _rules(cases):
        legitimate = pictured and not hidden
        seen = _look(task, _scored(scores, cases, sets, known))
        line = ProbeSpec(f"`{known}` and {rule}", "combination", False, _SHOWN if legitimate else _RIVAL, seen)
        (shown if legitimate else judged).append(line)
    return [task.probe(alone), *task.rivals("{} (the best rule)", _WHY, judged), *map(task.probe, shown)]


def _is_hidden(unit: Unit, options: ClosedSet, known: str, cases: Sequence[Case], moments: int) -> bool:
    """Whether one picture must not show the other factors: they are given in words, or are a motion."""
    still = min(moments, cases[0].moments) <= 1
    return all(
        given_in_words(unit, name) or (options.kinds[name] == "action" and not still) for name in options.others(known)
    )


# ---------------------------------------------------------------- rules


def _rules(cases: Sequence[Case]) -> Iterator[tuple[str, list[Array], bool]]:
    """Yield rules: the name, the score of every question's options, and whether the rule sees a context picture."""
    yield "the order of the options", [-np.arange(c.count, dtype=np.float64) for c in cases], False
    yield "the difference from the other options", [from_others(c) for c in cases], False
    for axis, name in (("across", "left or right"), ("down", "high or low")):
        yield f"the option with its objects {name}", [_mean_position(c, axis) for c in cases], False
    shown = len(cases[0].context_thumbnails)
    for view, name in {0: "first", shown - 1: "last"}.items() if shown else ():
        yield f"likeness to the {name} picture", [_likeness(c, view) for c in cases], True
    if shown and state.has_object_states(cases):
        yield "the distance of the objects from the last picture", [-_steps(c) for c in cases], True
        yield "the turn of the objects from the last picture", [-_turns(c) for c in cases], True


def _likeness(case: Case, view: int) -> Array:
    return np.array([-pixel_difference(option, case.context_thumbnails[view]) for option in case.option_thumbnails])


def _mean_position(case: Case, axis: str) -> Array:
    """Return the mean position of the visible objects of each option along an axis of the picture; 0 without any."""
    pictures = state.objects_by_picture(case, "option_objects")
    return np.array([np.mean([seen[axis] for seen in p.values() if seen["share"]] or [0.0]) for p in pictures])


def _steps(case: Case) -> Array:
    """Return the summed displacement of the objects of each option since the last picture; 1 for one that is gone."""
    return _compare(case, lambda a, b: float(np.hypot(a["across"] - b["across"], a["down"] - b["down"])))


def _turns(case: Case) -> Array:
    """Return the summed rotation of the objects of each option since the last picture, as 1 - cos(half the angle)."""
    names = ("qw", "qx", "qy", "qz")
    return _compare(case, lambda a, b: 1 - min(1.0, abs(sum(a[name] * b[name] for name in names))))


def _compare(case: Case, compare: Callable[[Row, Row], float]) -> Array:
    """Return the sum of a comparison over the objects of each option and the same in the last picture."""
    last = state.objects_by_picture(case, "context_objects")[-1]
    return np.array(
        [
            sum(
                compare(seen, last[n]) if seen["share"] and last[n]["share"] else 1.0
                for n, seen in p.items()
                if n in last
            )
            for p in state.objects_by_picture(case, "option_objects")
        ]
    )


# ---------------------------------------------------------------- features


def _look(task: ProbedQuestions, features: Array) -> Look:
    """Return the features without columns that follow from the others; these keep a lasso from converging."""
    x = task.data.centred(features[task.kept])
    _, triangle, order = linalg.qr(x, mode="economic", pivoting=True)
    size = abs(np.diag(triangle))
    columns = np.sort(order[: max(1, int((size > 1e-9 * max(1.0, size.max())).sum()))])
    return lambda: ProbeFeatures(features[:, columns], "options", "linear")


def _scored(scores: Sequence[Array], cases: Sequence[Case], sets: Sequence[ClosedSet], known: str) -> Array:
    """Return the ranks of the options by a rule, in both ways, and the same for each level of the known factor."""
    ranks = []
    for score, case, one in zip(scores, cases, sets, strict=True):
        left = np.array(one.left(known, case.row["answer"]))
        levels = list(zip(*(one.levels[name] for name in one.others(known)), strict=True))
        best = np.array([max(s for s, other in zip(score, levels, strict=True) if other == mine) for mine in levels])
        ranks.append(np.stack([_rank(score, left), _rank(best, left)], axis=1))
    return _by_level(np.concatenate(ranks), cases, sets, known)


def _rank(score: Array, left: NDArray[np.bool_]) -> Array:
    """Return each option's rank among those that are left: lower minus higher scores."""
    return np.asarray(np.sign((score[:, None] - score).round(9))[:, left].sum(1))


def _alone(cases: Sequence[Case], sets: Sequence[ClosedSet], known: str) -> Array:
    """Return the other factors and the kind of outcome of each option, for each level of the known factor."""
    words = [
        [*(f"{name} {one.levels[name][i]}" for name in one.others(known)), f"kind {outcomes[i]}"]
        for case, one in zip(cases, sets, strict=True)
        for outcomes in [case.row.get("option_outcome") or [""] * case.count]
        for i in range(case.count)
    ]
    vocabulary = sorted({word for of_option in words for word in of_option})
    return _by_level(np.array([[float(w in of_one) for w in vocabulary] for of_one in words]), cases, sets, known)


def _by_level(features: Array, cases: Sequence[Case], sets: Sequence[ClosedSet], known: str) -> Array:
    """Return the products of the features (options, d) with each level of the known factor."""
    level = [
        one.levels[known][case.row["answer"]] for case, one in zip(cases, sets, strict=True) for _ in range(case.count)
    ]
    given = np.array(level)[:, None] == sorted(set(level))
    return np.concatenate([features * given[:, [i]] for i in range(given.shape[1])], axis=1)
