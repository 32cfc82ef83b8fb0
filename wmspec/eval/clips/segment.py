"""Finds objects in a clip: what differs from the background and has the colours of the object, of all that moves.

Without the colours of everything else that moves, a bystander would be taken for an object that is hidden. Lightness
counts less than hue, because of shadows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.film.codec import Frames
from wmspec.dataset.film.distances import Array, mask_points
from wmspec.eval.clips.packages import opencv

Mask = NDArray[np.bool_]
#: Colours (k, 3) in Lab.
Palette = NDArray[np.float32]

#: Colours of a palette, the least share of pixels that one has, and the least number of pixels.
COLOURS, MIN_SHARE, MIN_PIXELS = 3, 0.15, 60
#: Weights of lightness: in the difference from the background, and in that from a palette.
PLATE_LIGHTNESS, PALETTE_LIGHTNESS = 0.5, 0.4
#: Differences (Lab of OpenCV, about ΔE): from the background at least, from the palette at most.
MIN_FOREGROUND, MAX_COLOUR = 9.0, 32.0
#: The palette must be nearer than this share of its distance from the background.
NEARER = 0.6
#: Smallest mask, as a share of the object's area; reach of its parts (widths); and memory of its place (px).
MIN_AREA, REACH, MEMORY = 0.06, 1.2, 60.0


def lab(frame: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return a picture in Lab."""
    cv2 = opencv()
    return np.asarray(cv2.cvtColor(frame, cv2.COLOR_RGB2LAB), np.float32)


def palette(frames: Frames, masks: Mask) -> Palette | None:
    """Return the main colours within masks; None if they are too small."""
    cv2 = opencv()
    pixels = []
    for frame, mask in zip(frames, masks, strict=True):
        inner = cv2.erode(mask.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
        if inner.any():
            pixels.append(lab(frame)[inner])
    if sum(map(len, pixels)) < MIN_PIXELS:
        return None
    found = np.concatenate(pixels)
    found = found[:: max(1, len(found) // 4000)]
    cv2.setRNGSeed(1)
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 20, 0.5)
    _, which, centres = cv2.kmeans(found, min(COLOURS, len(found)), None, criteria, 1, cv2.KMEANS_PP_CENTERS)
    shares = np.bincount(which.ravel(), minlength=len(centres)) / len(found)
    return np.asarray(centres[shares >= MIN_SHARE], np.float32)


def distance_to(picture: NDArray[np.float32], colours: Palette) -> NDArray[np.float32]:
    """Return the distance (h, w) of each pixel (Lab) from the nearest colour of a palette."""
    gaps = [_weighted(picture - colour, PALETTE_LIGHTNESS) for colour in colours]
    return np.asarray(np.minimum.reduce(gaps), np.float32)


def _weighted(gap: NDArray[np.float32], lightness: float) -> NDArray[np.float32]:
    return np.asarray(np.sqrt((lightness * gap[..., 0]) ** 2 + gap[..., 1] ** 2 + gap[..., 2] ** 2), np.float32)


def foreground(frames: Frames, plate: NDArray[np.uint8], valid: Mask) -> Mask:
    """Return the pixels (n, h, w) that differ from the background."""
    ground = lab(plate)
    return np.stack([(_weighted(lab(frame) - ground, PLATE_LIGHTNESS) > MIN_FOREGROUND) & valid for frame in frames])


def cleaned(masks: Mask) -> Mask:
    """Return masks (n, h, w) without specks and thin lines."""
    cv2 = opencv()
    kernel = np.ones((3, 3), np.uint8)
    return np.stack([cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, kernel) > 0 for mask in masks])


class Segmenter:
    """Finds objects by their palettes, given the background. `widths` are those of the objects (px)."""

    def __init__(
        self, plate: NDArray[np.uint8], palettes: Mapping[int, Palette], objects: Sequence[int], widths: Array
    ) -> None:
        self._objects, self._widths = objects, widths
        self._palettes = {body: colours for body, colours in palettes.items() if body in objects}
        others = {body: colours for body, colours in palettes.items() if body not in objects}
        self._palettes |= {body: colours for body, colours in others.items() if self._is_other(colours)}
        ground = lab(plate)
        self._from_plate = {body: distance_to(ground, colours) for body, colours in self._palettes.items()}

    def _is_other(self, colours: Palette) -> bool:
        """Whether colours are unlike those of every object; equal ones would take the object's pixels."""
        own = [colour for body in self._objects if body in self._palettes for colour in self._palettes[body]]
        return all(float(_weighted((a - b)[None], PALETTE_LIGHTNESS)[0]) > MIN_FOREGROUND for a in colours for b in own)

    def masks(self, frames: Frames, differs: Mask, places: Array) -> Mask:
        """Return the masks (objects, n, h, w) in frames.

        `differs` are the pixels unlike the background, `places` (objects, 2) px where each object is before the first
        frame, NaN if that is unknown.
        """
        found = np.zeros((len(self._objects), *differs.shape), bool)
        last = {k: place for k, place in enumerate(places) if not np.isnan(place).any()}
        for t, frame in enumerate(frames):
            picture = lab(frame)
            gaps = {body: distance_to(picture, colours) for body, colours in self._palettes.items()}
            nearest = np.minimum.reduce(list(gaps.values()))
            for k, body in enumerate(self._objects):
                if body not in gaps:
                    continue
                near = np.minimum(MAX_COLOUR, NEARER * np.maximum(self._from_plate[body], 1.0))
                mask = differs[t] & (gaps[body] <= nearest) & (gaps[body] < near)
                found[k, t] = self._component(mask, k, last)
        return found

    def _component(self, mask: Mask, k: int, last: dict[int, NDArray[np.float64]]) -> Mask:
        """Return the largest part of a mask, rather one near the object's last place, with what lies around it."""
        cv2 = opencv()
        opened = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, np.ones((2, 2), np.uint8))
        count, labels, stats, centres = cv2.connectedComponentsWithStats(opened, connectivity=8)
        width = self._widths[k]
        if count < 2:
            return np.zeros(mask.shape, bool)
        areas, centres = stats[1:, 4].astype(float), centres[1:]
        weights = areas
        if k in last:
            weights = areas * np.exp(-np.hypot(*(centres - last[k]).T) / MEMORY)
        best = int(np.argmax(weights))
        if areas[best] < max(8.0, MIN_AREA * width**2):
            return np.zeros(mask.shape, bool)
        last[k] = centres[best]
        near = (np.hypot(*(centres - centres[best]).T) < REACH * width) & (areas >= 6)
        return np.asarray(np.isin(labels, 1 + np.nonzero(near)[0]))


def points_of(masks: Mask) -> Array:
    """Return the points (objects, n, 3, 2) of masks."""
    return np.array([[mask_points(mask) for mask in of_object] for of_object in masks])
