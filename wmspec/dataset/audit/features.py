"""What the probes see of a question's options, as numbers."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.audit.cases import SIDE, Case, Small

Array = NDArray[np.float64]

#: Pixels a side that a probe sees of a picture, and levels of each colour in a histogram.
PIXELS, LEVELS = 8, 4
#: The principal components of pixels that are looked at.
MOST_PIXELS = 16
#: Those of words crossed with words.
MOST_TEXTS = 24
#: The most words, names and texts that are told apart: the most frequent ones.
MOST_WORDS = 40

_WORD = re.compile(r"[^\W_]+(?:\.\d+)?|[+-]")


def _pixels(picture: Small) -> Array:
    """A picture as (PIXELS * PIXELS * 3) values from 0 to 1."""
    block = SIDE // PIXELS
    means = picture.reshape(PIXELS, block, PIXELS, block, 3).mean((1, 3))
    return np.asarray(means.ravel() / 255)


def _histogram(picture: Small) -> Array:
    """The share of a picture's pixels in each of LEVELS ** 3 colours."""
    level = (picture.astype(np.int64) * LEVELS) // 256
    code = (level[..., 0] * LEVELS + level[..., 1]) * LEVELS + level[..., 2]
    return np.bincount(code.ravel(), minlength=LEVELS**3) / code.size


# ---------------------------------------------------------------- of options alone


def positions(cases: Sequence[Case]) -> Array:
    """Where an option stands."""
    places = np.eye(max(c.count for c in cases))
    return np.concatenate([places[: c.count] for c in cases])


def options(cases: Sequence[Case]) -> Array:
    """The options alone: their pixels, or their words, and how they stand to each other."""
    if cases[0].pictured:
        return leading(np.concatenate([_among([_pixels(p) for p in c.seen_options]) for c in cases]), MOST_PIXELS)
    return np.concatenate([_words_of(cases), np.concatenate([_ranks(c.row["option_text"]) for c in cases])], axis=1)


def colours(cases: Sequence[Case]) -> Array:
    """The colours of the option pictures, and how they stand to each other."""
    return leading(np.concatenate([_among([_histogram(p) for p in c.seen_options]) for c in cases]), MOST_PIXELS)


def texts(cases: Sequence[Case]) -> Array:
    """The words of the question with those of the option; with its place, if options are pictures."""
    option = positions(cases) if cases[0].pictured else _words_of(cases)
    asked = _bag([_words(c.row["text"]) for c in cases])
    asked = asked[:, asked.std(0) > 0]  # what every question says tells nothing
    each = np.split(_crossed(option, np.repeat(asked, [c.count for c in cases], axis=0)), _ends(cases))
    return leading(np.concatenate([of_one - of_one.mean(0) for of_one in each]), MOST_TEXTS)


def _ends(cases: Sequence[Case]) -> list[int]:
    """After how many options each question but the last ends."""
    return [int(end) for end in np.cumsum([c.count for c in cases])[:-1]]


# ---------------------------------------------------------------- with pictures of the context


def pixels(cases: Sequence[Case], views: Sequence[int]) -> Array:
    """The pixels of the pictures `views`: a row a question, or, with options that are pictures, how each differs."""
    shown = np.stack([np.concatenate([_look(c.seen_context[v]) for v in views]) for c in cases])
    if not cases[0].pictured:
        return leading(shown, MOST_PIXELS)
    gaps = [
        np.stack([np.tile(_look(o), len(views)) for o in c.seen_options]) - s for c, s in zip(cases, shown, strict=True)
    ]
    either = (np.concatenate([gap, abs(gap)], axis=1) for gap in gaps)
    return leading(np.concatenate([gap - gap.mean(0) for gap in either]), MOST_PIXELS)


def _look(picture: Small) -> Array:
    return np.concatenate([_pixels(picture), _histogram(picture)])


# ---------------------------------------------------------------- pieces


def _among(seen: Sequence[Array]) -> Array:
    """Each of a question's options (n, d) as it is, as far as it is from their mean, and its rank in distance.

    Counterfactuals change one thing of the truth each, so that the truth is apt to lie in their middle.
    """
    x = np.stack(seen)
    away = abs(x - x.mean(0))
    apart = np.linalg.norm(x[:, None] - x, axis=2).sum(1)
    rank = np.eye(len(x))[np.argsort(np.argsort(apart, kind="stable"))]
    return np.concatenate(
        [x - x.mean(0), away, apart[:, None], np.pad(rank, ((0, 0), (0, max(0, 8 - len(x)))))[:, :8]], axis=1
    )


def _ranks(texts: Sequence[str]) -> Array:
    """The rank of an option by its number and by its length, if it has one."""
    numbers = [float(m[0]) if (m := re.search(r"-?\d+(?:\.\d+)?", s)) else 0.0 for s in texts]
    n = len(texts)
    ranks = np.zeros((n, 9))
    ranks[np.arange(n), np.minimum(np.argsort(np.argsort(numbers, kind="stable")), 7)] = len(set(numbers)) > 1
    ranks[:, 8] = [len(s) for s in texts]
    return ranks


def _words_of(cases: Sequence[Case]) -> Array:
    return _bag([[*_words(s), f"= {s}"] for c in cases for s in c.row["option_text"]])


def _words(text: str) -> list[str]:
    return _WORD.findall(text.lower())


def _bag(words: Sequence[Iterable[str]]) -> Array:
    """Which of the most frequent words each text has: (texts, words), at least one column wide."""
    sets = [set(s) for s in words]
    count = Counter(word for s in sets for word in s)
    known = sorted(count, key=lambda w: (-count[w], w))[:MOST_WORDS]
    return np.array([[float(w in s) for w in known] or [0.0] for s in sets])


def _crossed(a: Array, b: Array) -> Array:
    """`a` and all products of a column of `a` and one of `b`."""
    return np.concatenate([a, (a[:, :, None] * b[:, None, :]).reshape(len(a), -1)], axis=1)


def leading(x: Array, most: int) -> Array:
    """The leading principal components."""
    x = x - x.mean(0)
    _, directions = np.linalg.eigh(x.T @ x)
    return np.asarray(x @ directions[:, -most:])
