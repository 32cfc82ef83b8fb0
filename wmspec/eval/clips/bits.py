"""Masks of eight pixels a byte: overlaps of many masks are counted without loops over pixels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.film.distances import Array

Mask = NDArray[np.bool_]
#: Masks (..., words) of 64 pixels a word; the last word is filled up with zeros.
Bits = NDArray[np.uint64]

_WORD = 64


def packed(masks: Mask) -> Bits:
    """Return masks (..., h, w) as words (..., ceil(h w / 64))."""
    flat = masks.reshape(*masks.shape[:-2], -1)
    length = -(-flat.shape[-1] // _WORD) * _WORD
    made = np.zeros((*flat.shape[:-1], length // 8), np.uint8)
    bytes_ = np.packbits(flat, axis=-1)
    made[..., : bytes_.shape[-1]] = bytes_
    return made.view(np.uint64)


def count(bits: Bits) -> NDArray[np.int64]:
    """Return the number of pixels of each mask."""
    return np.asarray(np.bitwise_count(bits).sum(axis=-1, dtype=np.int64))


def overlaps(a: Bits, b: Bits) -> Array:
    """Return the intersection over union of each pair of masks; 1 if both are empty."""
    both, either = count(a & b), count(a | b)
    return np.asarray(np.where(either == 0, 1.0, both / np.maximum(either, 1)))
