"""What the probes see of a question's options, as numbers."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from wmspec.audit.cases import SIDE, Case, Small

Array = NDArray[np.float64]

#: Pixels a side that a probe sees of a picture, and levels of each colour in a histogram.
PIXELS, LEVELS = 8, 4
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
        return np.concatenate([_among([_pixels(p) for p in c.seen_options]) for c in cases])
    return np.concatenate([_words_of(cases), np.concatenate([_ranks(c.row["option_text"]) for c in cases])], axis=1)


def colours(cases: Sequence[Case]) -> Array:
    """The colours of the option pictures, and how they stand to each other."""
    return np.concatenate([_among([_histogram(p) for p in c.seen_options]) for c in cases])


def texts(cases: Sequence[Case]) -> Array:
    """The words of the question with those of the option; with its place, if options are pictures."""
    option = np.concatenate(
        [positions(cases), _names(cases)] if cases[0].pictured else [positions(cases), options(cases)], 1
    )
    asked = _bag([_said(c.row["text"]) for c in cases])
    asked = asked[:, asked.std(0) > 0]  # what every question says tells nothing
    return _crossed(option, np.repeat(asked, [c.count for c in cases], axis=0))


# ---------------------------------------------------------------- with one picture of the context


def frame(see: Callable[[Small], Array], which: int) -> Callable[[Sequence[Case]], Array]:
    """The context's picture `which` with the options: what differs between it and an option picture, or, if options
    are words, the picture with the option's words.
    """

    def seen(cases: Sequence[Case]) -> Array:
        views = np.stack([see(c.seen_context[which]) for c in cases])
        if cases[0].pictured:
            gaps = [np.stack([see(o) for o in c.seen_options]) - v for c, v in zip(cases, views, strict=True)]
            return np.concatenate([np.concatenate([g, abs(g)], 1) for g in gaps])
        views = views - views.mean(0)
        views = _leading(np.concatenate([views, abs(views)], 1), 60)
        each = np.repeat(views, [c.count for c in cases], axis=0)
        return _crossed(np.concatenate([_names(cases), _words_of(cases)], 1), each)

    return seen


def pixels(which: int) -> Callable[[Sequence[Case]], Array]:
    """One picture of the context with the options."""
    return frame(_pixels, which)


def tones(which: int) -> Callable[[Sequence[Case]], Array]:
    """The colours of one picture of the context with the options."""
    return frame(_histogram, which)


# ---------------------------------------------------------------- pieces


def _among(seen: Sequence[Array]) -> Array:
    """Each of a question's options (n, d) as it is, as far as it is from their mean, and its rank in distance.

    Counterfactuals change one thing of the truth each, so that the truth is apt to lie in their middle.
    """
    x = np.stack(seen)
    away = abs(x - x.mean(0))
    apart = np.linalg.norm(x[:, None] - x, axis=2).sum(1)
    rank = np.eye(len(x))[np.argsort(np.argsort(apart, kind="stable"))]
    return np.concatenate([x, away, apart[:, None], np.pad(rank, ((0, 0), (0, max(0, 8 - len(x)))))[:, :8]], axis=1)


def _ranks(texts: Sequence[str]) -> Array:
    """The rank of an option by its number and by its length, if it has one."""
    numbers = [float(m[0]) if (m := re.search(r"-?\d+(?:\.\d+)?", s)) else 0.0 for s in texts]
    n = len(texts)
    ranks = np.zeros((n, 9))
    ranks[np.arange(n), np.minimum(np.argsort(np.argsort(numbers, kind="stable")), 7)] = len(set(numbers)) > 1
    ranks[:, 8] = [len(s) for s in texts]
    return ranks


def _words_of(cases: Sequence[Case]) -> Array:
    return _bag([[*_said(s), f"= {s}"] for c in cases for s in c.row["option_text"]])


def _names(cases: Sequence[Case]) -> Array:
    """What the spec calls an option's object or value. Of pictures the names would give the truth away: none."""
    return _bag([[] if c.pictured else [name] for c in cases for name in c.row["option_name"]])


def _said(text: str) -> list[str]:
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


def _leading(x: Array, most: int) -> Array:
    """The leading principal components."""
    x = x - x.mean(0)
    _, directions = np.linalg.eigh(x.T @ x)
    return np.asarray(x @ directions[:, -most:])
