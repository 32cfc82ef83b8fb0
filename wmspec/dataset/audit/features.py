"""Features of options and pictures for probes."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence

import numpy as np

from wmspec.dataset.audit.cases import THUMBNAIL_SIZE, Case, Thumbnail
from wmspec.dataset.film.distances import Array

#: Side of a picture for probes (px), and levels of each colour in a histogram.
GRID_SIZE, COLOUR_LEVELS = 8, 4
#: Number of principal components of pixels.
MAX_PIXEL_COMPONENTS = 16
#: Number of principal components of word pairs.
MAX_TEXT_COMPONENTS = 24
#: Smallest variance of a principal component, relative to the largest. A smaller one is a rounding error, and scaled up
#: it keeps a lasso from converging.
MIN_VARIANCE_SHARE = 1e-10
#: Maximum vocabulary size; the most frequent words, names and texts are used.
MAX_VOCABULARY = 40

_WORD = re.compile(r"[^\W_]+(?:\.\d+)?|[+-]")


def _pixels(picture: Thumbnail) -> Array:
    """Return a picture as (PIXELS * PIXELS * 3) values from 0 to 1."""
    block = THUMBNAIL_SIZE // GRID_SIZE
    means = picture.reshape(GRID_SIZE, block, GRID_SIZE, block, 3).mean((1, 3))
    return np.asarray(means.ravel() / 255)


def _histogram(picture: Thumbnail) -> Array:
    """Return the share of a picture's pixels in each of LEVELS ** 3 colours."""
    level = (picture.astype(np.int64) * COLOUR_LEVELS) // 256
    code = (level[..., 0] * COLOUR_LEVELS + level[..., 1]) * COLOUR_LEVELS + level[..., 2]
    return np.bincount(code.ravel(), minlength=COLOUR_LEVELS**3) / code.size


# ---------------------------------------------------------------- options alone


def positions(cases: Sequence[Case]) -> Array:
    """Return the position of each option."""
    places = np.eye(max(c.count for c in cases))
    return np.concatenate([places[: c.count] for c in cases])


def options(cases: Sequence[Case]) -> Array:
    """Return features of the options alone: pixels or words, and their relation to the other options."""
    if cases[0].has_picture_options:
        return principal_components(
            np.concatenate([_relative_to_options([_pixels(p) for p in c.option_thumbnails]) for c in cases]),
            MAX_PIXEL_COMPONENTS,
        )
    return np.concatenate([_words_of(cases), np.concatenate([_ranks(c.row["option_text"]) for c in cases])], axis=1)


def colours(cases: Sequence[Case]) -> Array:
    """Return the colours of option pictures, and their relation to the other options."""
    return principal_components(
        np.concatenate([_relative_to_options([_histogram(p) for p in c.option_thumbnails]) for c in cases]),
        MAX_PIXEL_COMPONENTS,
    )


def texts(cases: Sequence[Case]) -> Array:
    """Return the words of question and option, crossed; with the position if options are pictures."""
    option = positions(cases) if cases[0].has_picture_options else _words_of(cases)
    question_words = _bag([_words(c.row["text"]) for c in cases])
    question_words = question_words[:, question_words.std(0) > 0]  # drop words that every question has
    counts = [c.count for c in cases]
    crossed = _with_products(option, np.repeat(question_words, counts, axis=0))
    each = np.split(crossed, np.cumsum(counts)[:-1])
    return principal_components(np.concatenate([of_one - of_one.mean(0) for of_one in each]), MAX_TEXT_COMPONENTS)


# ---------------------------------------------------------------- context pictures


def pixels(cases: Sequence[Case], views: Sequence[int]) -> Array:
    """Return the pixels of the pictures `views`: one row a question, or differences to the options if these are
    pictures.
    """
    shown = np.stack([np.concatenate([_look(c.context_thumbnails[v]) for v in views]) for c in cases])
    if not cases[0].has_picture_options:
        return principal_components(shown, MAX_PIXEL_COMPONENTS)
    gaps = [
        np.stack([np.tile(_look(o), len(views)) for o in c.option_thumbnails]) - s
        for c, s in zip(cases, shown, strict=True)
    ]
    either = (np.concatenate([gap, abs(gap)], axis=1) for gap in gaps)
    return principal_components(np.concatenate([gap - gap.mean(0) for gap in either]), MAX_PIXEL_COMPONENTS)


def _look(picture: Thumbnail) -> Array:
    return np.concatenate([_pixels(picture), _histogram(picture)])


# ---------------------------------------------------------------- helpers


def _relative_to_options(seen: Sequence[Array]) -> Array:
    """Return each option (n, d), its deviation from the mean of the options, and its rank by distance from it.

    Counterfactuals change one aspect of the truth each, so that the truth tends to lie in their middle.
    """
    x = np.stack(seen)
    away = abs(x - x.mean(0))
    apart = np.linalg.norm(x[:, None] - x, axis=2).sum(1)
    rank = np.eye(len(x))[np.argsort(np.argsort(apart, kind="stable"))]
    return np.concatenate(
        [x - x.mean(0), away, apart[:, None], np.pad(rank, ((0, 0), (0, max(0, 8 - len(x)))))[:, :8]], axis=1
    )


def _ranks(texts: Sequence[str]) -> Array:
    """Return the ranks of options by their number and by their length."""
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
    """Return the occurrence of the most frequent words in each text: (texts, words), at least one column."""
    sets = [set(s) for s in words]
    count = Counter(word for s in sets for word in s)
    known = sorted(count, key=lambda w: (-count[w], w))[:MAX_VOCABULARY]
    return np.array([[float(w in s) for w in known] or [0.0] for s in sets])


def _with_products(a: Array, b: Array) -> Array:
    """Return `a` and all products of its columns with those of `b`."""
    return np.concatenate([a, (a[:, :, None] * b[:, None, :]).reshape(len(a), -1)], axis=1)


def principal_components(x: Array, most: int) -> Array:
    """Return the leading principal components with a variance above rounding errors: (samples, at most `most`)."""
    x = x - x.mean(0)
    variances, directions = np.linalg.eigh(x.T @ x)
    significant = int((variances > MIN_VARIANCE_SHARE * variances[-1]).sum())
    return np.asarray(x @ directions[:, -max(1, min(most, significant)) :])
