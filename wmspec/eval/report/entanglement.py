"""s-RE, the standardized relative entanglement of the paper: does accuracy hang on what the question is not about?

Of a factor with N levels, p_i the accuracy at level i and p̄ the mean of the p_i, it is the mean of |1 − p_i / p̄|
(Gao et al., 2025, section 5). Even a system that does not look at the factor has some, by chance: so it is told beside
what it is when the levels are shuffled over the instances.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from wmspec.eval.report.intervals import Floats, ratio, rng
from wmspec.eval.report.questions import Questions
from wmspec.eval.report.replies import Replies
from wmspec.lang.check.tables.vocabulary import WORDS

#: How often levels are shuffled; how many levels a factor may have, and how many questions each must have.
SHUFFLES, MOST_LEVELS, LEAST_QUESTIONS = 300, 12, 5
#: Stimulus differences are not the same if they are this much of their mean apart; answers go with a factor from this
#: V on.
LEAST_STEP, LEAST_ASSOCIATION = 0.1, 0.3

#: The paper's five dimensions, each with the words by which names of factors tell it where their values do not.
DIMENSIONS: dict[str, frozenset[str]] = {
    "colour": frozenset(["color", "colors", "colour", "colours", "tone", "shade", "hue", "warm", "cold"]),
    "shape": frozenset(["shape", "shapes", "form", "forms", "kind"]),
    "size": frozenset(
        [
            "size",
            "small",
            "large",
            "ratio",
            "share",
            "edge",
            "height",
            "tall",
            "radius",
            "width",
            "length",
            "hollow",
            "scale",
            "volume",
        ]
    ),
    "position": frozenset(
        [
            "position",
            "at",
            "where",
            "spot",
            "start",
            "place",
            "lane",
            "way",
            "hand",
            "side",
            "far",
            "near",
            "swapped",
            "deal",
            "corner",
            "up",
            "ahead",
            "x",
            "y",
            "shift",
            "low",
        ]
    ),
    "material": frozenset(["material", "stuff", "texture", "surface"]),
}


@dataclass(frozen=True)
class Entangled:
    """s-RE of a task by one factor: `value`, and when shuffled its `mean` and the `bound` that 95 % stay below.

    `p` is how often shuffling yields as much. `dimension` is the one of the paper's five that the factor is of, or "".
    If it is `asked`, the answer or the stimulus difference hangs on it: it is what the question is about, and
    accuracy may hang on it.
    """

    task: str
    question: str
    factor: str
    dimension: str
    asked: bool
    system: str
    levels: int
    questions: int
    value: float
    mean: float
    bound: float
    p: float


def entanglement(replies: Replies) -> tuple[Entangled, ...]:
    """For each task, question, factor or nuisance with a few levels, and system. Needs the dataset."""
    if replies.questions is None:
        return ()
    asked = replies.asked
    parts = asked.groupby(["task", "question_name"], sort=True)
    return tuple(e for (task, name), of_one in parts for e in _question(replies, str(task), str(name), of_one))


def _question(replies: Replies, task: str, name: str, asked: pd.DataFrame) -> Iterator[Entangled]:
    assert replies.questions is not None
    varied = replies.questions.varied[task].loc[asked.index]
    scores = replies.scores.loc[asked.index].to_numpy()
    for factor in varied.columns:
        codes, levels = pd.factorize(varied[factor].astype(str), sort=True)
        if 2 <= len(levels) <= MOST_LEVELS and np.bincount(codes).min() >= LEAST_QUESTIONS:
            facet = dimension(factor, varied[factor])
            about = _asked(replies.questions, task, factor, asked.index)
            yield from _factor(replies, (task, name, factor, facet, about), codes, scores, asked["index"].to_numpy())


def _factor(
    replies: Replies,
    key: tuple[str, str, str, str, bool],
    codes: NDArray[np.intp],
    scores: Floats,
    instance: NDArray[np.int64],
) -> Iterator[Entangled]:
    value = spread(codes, scores)
    shuffled = _shuffled(codes, scores, instance, key)
    for j, system in enumerate(replies.systems):
        drawn = shuffled[:, j][~np.isnan(shuffled[:, j])]
        if np.isnan(value[j]) or not len(drawn):
            continue
        as_much = (1 + int((drawn >= value[j] - 1e-12).sum())) / (1 + len(drawn))
        asked = int((~np.isnan(scores[:, j])).sum())
        yield Entangled(
            *key, system, int(codes.max()) + 1, asked,
            float(value[j]), float(drawn.mean()), float(np.quantile(drawn, 0.95)), as_much,
        )  # fmt: skip


def _asked(questions: Questions, task: str, factor: str, ids: pd.Index[str]) -> bool:
    """Whether the answer or the difference is another where the factor alone is.

    Where no two such questions were asked, whether answers go with the factor's levels.
    """
    if factor not in questions.groups[task]:
        return False  # a nuisance
    known = questions.table.loc[ids]
    strong = known["difference"].abs()
    alone = pd.DataFrame({"truth": known["truth"], "strength": strong}).groupby(
        [questions.groups[task].loc[ids, factor].astype(str), known["question"], known["engine"]]
    )
    apart = alone["strength"].max() - alone["strength"].min()
    if (alone["truth"].nunique() > 1).any() or (apart > LEAST_STEP * strong.abs().mean()).any():
        return True
    if (alone.size() > 1).any() or known["truth"].nunique() < 2:
        return False
    return _association(known["truth"], questions.varied[task].loc[ids, factor].astype(str)) > LEAST_ASSOCIATION


def _association(first: pd.Series[str], second: pd.Series[str]) -> float:
    """Cramér's V of two lists of words."""
    from scipy.stats.contingency import association

    table = pd.crosstab(first, second).to_numpy()
    return float(association(table)) if min(table.shape) > 1 else 0.0


def spread(codes: NDArray[np.intp], scores: Floats) -> Floats:
    """s-RE of scores (n, m) by levels (n,): (m,), NaN where a level was not asked or nothing is right."""
    at = np.zeros((int(codes.max()) + 1, len(codes)))
    at[codes, np.arange(len(codes))] = 1
    p = ratio(at @ np.nan_to_num(scores), at @ (~np.isnan(scores)).astype(float))
    middle = p.mean(0)
    off = abs(middle - p).mean(0)
    return ratio(off, middle)


def _shuffled(codes: NDArray[np.intp], scores: Floats, instance: NDArray[np.int64], key: object) -> Floats:
    """s-RE (SHUFFLES, m) with levels dealt out anew: the rows of an instance, of several engines, keep one level."""
    _, first, which = np.unique(instance, return_index=True, return_inverse=True)
    generator = rng("shuffle", *np.atleast_1d(np.asarray(key, dtype=str)))
    return np.stack([spread(generator.permutation(codes[first])[which], scores) for _ in range(SHUFFLES)])


def dimension(factor: str, values: pd.Series[str]) -> str:
    """Which of the paper's five dimensions a factor is of: by its values, else by the words of its name; "" of none."""
    levels = {str(v) for v in values.unique()}
    for name, words in (("colour", "color"), ("shape", "shape"), ("material", "material")):
        if levels <= set(WORDS[words]):
            return name
    parts = re.split(r"[_\d]+", factor.lower())
    return next((d for word in reversed(parts) for d, words in DIMENSIONS.items() if word in words), "")
