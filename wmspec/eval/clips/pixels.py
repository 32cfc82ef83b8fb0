"""Comparisons of clips without objects: thumbnails, gradient histograms, and the four measures of Physics-IQ."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.film.codec import Frames
from wmspec.dataset.film.distances import Array, Mask
from wmspec.eval.clips.packages import opencv

#: Sides (px) of thumbnails, of the picture whose gradients are counted, and of a cell; orientations of gradients.
THUMBNAIL, GRADIENT_SIDE, CELL, BINS = 64, 128, 8, 8
#: Added to the norm of a histogram, so that noise is no gradient.
QUIET = 40.0
#: Largest difference of a thumbnail cell (sum of channels).
MAX_GAP = 120.0
#: Parameters of Physics-IQ's motion masks: threshold (grey levels), weight of the running mean, kernel (px).
MOTION, RUNNING, KERNEL = 10, 0.3, 5


def thumbnails(frames: Frames) -> NDArray[np.int16]:
    """Return frames as thumbnails (n, 64, 64, 3)."""
    cv2 = opencv()
    side = THUMBNAIL, THUMBNAIL
    return np.stack([cv2.resize(f, side, interpolation=cv2.INTER_AREA) for f in frames]).astype(np.int16)


def gradients(frames: Frames) -> NDArray[np.float32]:
    """Return the histograms of gradient orientations of frames (n, 16, 16, 8), each normalized (Dalal, Triggs 2005)."""
    cells = GRADIENT_SIDE // CELL
    across = np.arange(GRADIENT_SIDE) // CELL
    first = (across[:, None] * cells + across) * BINS
    histograms = np.stack([_gradient_histogram(frame, first) for frame in frames])
    return np.asarray(histograms / (np.linalg.norm(histograms, axis=-1, keepdims=True) + QUIET), np.float32)


def _gradient_histogram(frame: NDArray[np.uint8], first: NDArray[np.intp]) -> Array:
    """Return the histograms of a frame, not normalized; `first` is the place of the first bin of each pixel's cell."""
    cv2 = opencv()
    side = GRADIENT_SIDE, GRADIENT_SIDE
    grey = cv2.resize(cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY), side, interpolation=cv2.INTER_AREA).astype(np.float32)
    dx, dy = cv2.Sobel(grey, cv2.CV_32F, 1, 0), cv2.Sobel(grey, cv2.CV_32F, 0, 1)
    strength, angle = cv2.cartToPolar(dx, dy)
    bins = (angle * (BINS / np.pi)).astype(np.intp) % BINS
    counts = np.bincount((first + bins).ravel(), strength.ravel(), first.max() + BINS)
    cells = GRADIENT_SIDE // CELL
    return np.asarray(counts.reshape(cells, cells, BINS), np.float64)


def thumbnail_gap(a: NDArray[np.int16], b: NDArray[np.int16], where: Mask) -> float:
    """Return the mean difference of thumbnails in the given cells; 0 without cells."""
    gaps = np.minimum(difference(a[where], b[where]), MAX_GAP)
    return float(gaps.mean()) if gaps.size else 0.0


def difference(a: NDArray[np.int16], b: NDArray[np.int16]) -> NDArray[np.int16]:
    """Return the difference of colours (..., 3), summed over the channels."""
    gaps = np.abs(a - b)
    return np.asarray(gaps[..., 0] + gaps[..., 1] + gaps[..., 2])


def gradient_gap(a: NDArray[np.float32], b: NDArray[np.float32], where: Mask) -> float:
    """Return the mean difference of gradient histograms in the given cells; 0 without cells."""
    gaps = np.linalg.norm(a[where] - b[where], axis=-1)
    return float(gaps.mean()) if gaps.size else 0.0


def shrink_mask(valid: Mask, side: int) -> Mask:
    """Return a mask (h, w) at another size."""
    cv2 = opencv()
    return np.asarray(cv2.resize(valid.astype(np.uint8), (side, side), interpolation=cv2.INTER_AREA) > 0)


# ---------------------------------------------------------------- Physics-IQ (Motamed et al., 2025)


def motion_masks(frames: Frames) -> Mask:
    """Return the pixels (n, h, w) that move: unlike a running mean, as Physics-IQ defines them."""
    cv2 = opencv()
    kernel = np.ones((KERNEL, KERNEL), np.uint8)
    greys = [cv2.GaussianBlur(cv2.cvtColor(f, cv2.COLOR_RGB2GRAY), (KERNEL, KERNEL), 0) for f in frames]
    mean = greys[0].astype(np.float64)
    masks = [np.zeros(greys[0].shape, bool)]
    for grey in greys[1:]:
        cv2.accumulateWeighted(grey, mean, RUNNING)
        moved = cv2.threshold(cv2.absdiff(grey, cv2.convertScaleAbs(mean)), MOTION, 255, cv2.THRESH_BINARY)[1]
        cleaned = cv2.morphologyEx(cv2.morphologyEx(moved, cv2.MORPH_OPEN, kernel), cv2.MORPH_CLOSE, kernel)
        masks.append(cleaned > 0)
    return np.stack(masks)


@dataclass(frozen=True)
class Motion:
    """Frames (n, h, w, 3) and the pixels (n, h, w) that move in them."""

    frames: Frames
    masks: Mask

    @classmethod
    def of(cls, frames: Frames) -> Motion:
        """Return the motion of frames."""
        return cls(frames, motion_masks(frames))

    @cached_property
    def each(self) -> Bits:
        """The masks of all frames."""
        return packed(self.masks)

    @cached_property
    def ever(self) -> Bits:
        """The pixels that move in a frame."""
        return np.asarray(np.bitwise_or.reduce(self.each, axis=0))

    @cached_property
    def often(self) -> NDArray[np.uint16]:
        """In how many frames each pixel (h, w) moves."""
        return np.asarray(self.masks.sum(axis=0, dtype=np.uint16))


def physics_iq(clip: Motion, truth: Motion) -> tuple[float, float, float, float]:
    """Return spatial, spatiotemporal and weighted spatial overlap of motion, and the mean squared error of pixels."""
    spatial = float(overlaps(clip.ever, truth.ever))
    each = overlaps(clip.each, truth.each)
    # The smaller and the larger number of each pixel, summed.
    total = int(count(clip.each).sum() + count(truth.each).sum())
    smaller = int(np.minimum(clip.often, truth.often).sum(dtype=np.int64))
    weighted = 1.0 if total == 0 else smaller / (total - smaller)
    error = sum(squared_error(x, y) for x, y in zip(clip.frames, truth.frames, strict=True))
    return spatial, float(np.mean(each)), weighted, error / clip.frames.size / 255**2


def squared_error(a: NDArray[np.uint8], b: NDArray[np.uint8], mask: Mask | None = None) -> float:
    """Return the sum of squared differences of two pictures (h, w, 3), within a mask (h, w) if there is one."""
    cv2 = opencv()
    return float(cv2.norm(a, b, cv2.NORM_L2SQR, None if mask is None else mask.astype(np.uint8)))


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
