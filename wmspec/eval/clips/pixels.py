"""Comparisons of clips without objects: thumbnails, gradient histograms, and the four measures of Physics-IQ."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.film.codec import Frames
from wmspec.dataset.film.distances import Array
from wmspec.eval.clips.packages import opencv

Mask = NDArray[np.bool_]

#: Sides (px) of thumbnails, of the picture whose gradients are counted, and of a cell; orientations of gradients.
THUMBNAIL, GRADIENT_SIDE, CELL, BINS = 64, 128, 8, 8
#: Added to the norm of a histogram, so that noise is no gradient.
QUIET = 40.0
#: Largest difference of a thumbnail cell (sum of channels).
MAX_GAP = 120.0
#: Parameters of Physics-IQ's motion masks: threshold (grey levels), weight of the running mean, kernel (px).
MOTION, RUNNING, KERNEL = 10, 0.3, 5


def thumbnails(frames: Frames) -> Array:
    """Return frames as thumbnails (n, 64, 64, 3)."""
    cv2 = opencv()
    side = THUMBNAIL, THUMBNAIL
    return np.stack([cv2.resize(f, side, interpolation=cv2.INTER_AREA) for f in frames]).astype(np.float64)


def gradients(frames: Frames) -> Array:
    """Return the histograms of gradient orientations of frames (n, 16, 16, 8), each normalized (Dalal, Triggs 2005)."""
    return np.stack([_gradient_histograms(frame) for frame in frames])


def _gradient_histograms(frame: NDArray[np.uint8]) -> Array:
    cv2 = opencv()
    side = GRADIENT_SIDE, GRADIENT_SIDE
    grey = cv2.resize(cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY), side, interpolation=cv2.INTER_AREA).astype(np.float32)
    dx, dy = cv2.Sobel(grey, cv2.CV_32F, 1, 0), cv2.Sobel(grey, cv2.CV_32F, 0, 1)
    strength, angle = cv2.cartToPolar(dx, dy)
    which = np.minimum((angle % np.pi * (BINS / np.pi)).astype(int), BINS - 1)
    cells = GRADIENT_SIDE // CELL
    across = np.arange(GRADIENT_SIDE) // CELL
    places = (across[:, None] * cells + across) * BINS + which
    counts = np.bincount(places.ravel(), strength.ravel(), cells * cells * BINS)
    histograms = counts.reshape(cells, cells, BINS)
    return np.asarray(histograms / (np.linalg.norm(histograms, axis=-1, keepdims=True) + QUIET))


def thumbnail_gap(a: Array, b: Array, where: Mask) -> float:
    """Return the mean difference of thumbnails in the given cells; 0 without cells."""
    gaps = np.minimum(np.abs(a - b).sum(axis=-1), MAX_GAP)[where]
    return float(gaps.mean()) if gaps.size else 0.0


def gradient_gap(a: Array, b: Array, where: Mask) -> float:
    """Return the mean difference of gradient histograms in the given cells; 0 without cells."""
    gaps = np.linalg.norm(a - b, axis=-1)[where]
    return float(gaps.mean()) if gaps.size else 0.0


def shrink_mask(valid: Mask, side: int) -> Mask:
    """Return a mask (h, w) at another size."""
    cv2 = opencv()
    return np.asarray(cv2.resize(valid.astype(np.uint8), (side, side), interpolation=cv2.INTER_AREA) > 0)


def intersection_over_union(a: Mask, b: Mask) -> float:
    """Return the overlap of two masks; 1 if both are empty."""
    union = np.count_nonzero(a | b)
    return 1.0 if union == 0 else np.count_nonzero(a & b) / union


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


def physics_iq(masks: Mask, truth: Mask, frames: Frames, truth_frames: Frames) -> tuple[float, float, float, float]:
    """Return spatial, spatiotemporal and weighted spatial overlap of motion, and the mean squared error of pixels."""
    spatial = intersection_over_union(np.asarray(masks.any(axis=0)), np.asarray(truth.any(axis=0)))
    each = [intersection_over_union(a, b) for a, b in zip(masks, truth, strict=True)]
    a, b = np.count_nonzero(masks, axis=0), np.count_nonzero(truth, axis=0)
    largest = int(np.maximum(a, b).sum())
    weighted = 1.0 if largest == 0 else int(np.minimum(a, b).sum()) / largest
    error = sum(squared_error(x, y) for x, y in zip(frames, truth_frames, strict=True)) / frames.size / 255**2
    return spatial, float(np.mean(each)), weighted, error


def squared_error(a: NDArray[np.uint8], b: NDArray[np.uint8], mask: Mask | None = None) -> float:
    """Return the sum of squared differences of two pictures (h, w, 3), within a mask (h, w) if there is one."""
    cv2 = opencv()
    return float(cv2.norm(a, b, cv2.NORM_L2SQR, None if mask is None else mask.astype(np.uint8)))
