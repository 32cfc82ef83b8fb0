"""Finds objects in a clip: what differs from the background and has the colours of the object, of all that moves.

Without the colours of everything else that moves, a bystander would be taken for an object that is hidden. Lightness
counts less than hue, because of shadows. What may belong to several objects of one colour, which may touch, belongs to
the one whose expected place is nearest: it is found for each future by itself, and compared with that future.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.film.codec import Frames
from wmspec.dataset.film.distances import Array, Mask, mask_points
from wmspec.eval.clips.packages import opencv
from wmspec.eval.clips.pixels import Bits, packed

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
#: Colours (Lab) as near as this to two objects may belong to either; as many such pixels of a frame are divided.
EQUAL_COLOUR, MIN_SHARED = 5.0, 12
#: The distance (px) from an object that is not seen.
NOWHERE = 255
#: Standard deviation (px) of the blur against noise.
SMOOTH = 1.0
#: Smallest mask, as a share of the object's area; reach of its parts (widths); and memory of its place (px).
MIN_AREA, REACH, MEMORY = 0.06, 1.2, 60.0


def lab(frame: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return a picture in Lab."""
    cv2 = opencv()
    return np.asarray(cv2.cvtColor(frame, cv2.COLOR_RGB2LAB), np.float32)


def smooth(frame: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return a picture without the noise of single pixels, as clips, films and the background are all compared."""
    cv2 = opencv()
    return np.asarray(cv2.GaussianBlur(frame, (0, 0), SMOOTH), np.uint8)


def palette(frames: Frames, masks: Mask) -> Palette | None:
    """Return the main colours within masks; None if they are too small."""
    cv2 = opencv()
    pixels = []
    for frame, mask in zip(frames, masks, strict=True):
        inner = cv2.erode(mask.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
        if inner.any():
            pixels.append(lab(smooth(frame))[inner])
    if sum(map(len, pixels)) < MIN_PIXELS:
        return None
    found = np.concatenate(pixels)
    found = found[:: max(1, len(found) // 4000)]
    cv2.setRNGSeed(1)
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 20, 0.5)
    _, which, centres = cv2.kmeans(found, min(COLOURS, len(found)), None, criteria, 1, cv2.KMEANS_PP_CENTERS)
    shares = np.bincount(which.ravel(), minlength=len(centres)) / len(found)
    return np.asarray(centres[shares >= MIN_SHARE], np.float32)


def joined(palettes: Sequence[Palette | None]) -> Palette | None:
    """Return the distinct colours of palettes; None without any."""
    made: list[NDArray[np.float32]] = []
    for colour in (colour for colours in palettes if colours is not None for colour in colours):
        if all(float(_weighted(colour - known, PALETTE_LIGHTNESS)) > MIN_FOREGROUND for known in made):
            made.append(colour)
    return np.stack(made) if made else None


def _away(pixels: NDArray[np.float32], colour: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the distance (n) of pixels (n, 3), Lab, from a colour of a palette."""
    return _weighted(pixels - colour, PALETTE_LIGHTNESS)


def _weighted(gap: NDArray[np.float32], lightness: float) -> NDArray[np.float32]:
    return np.asarray(np.sqrt((lightness * gap[..., 0]) ** 2 + gap[..., 1] ** 2 + gap[..., 2] ** 2), np.float32)


def cleaned(masks: Mask) -> Mask:
    """Return masks (n, h, w) without specks and thin lines."""
    cv2 = opencv()
    kernel = np.ones((3, 3), np.uint8)
    return np.stack([cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, kernel) > 0 for mask in masks])


def distances_from(masks: Mask) -> NDArray[np.uint8]:
    """Return how far (px across and down, at most `NOWHERE`) each pixel is from the mask of its frame (n, h, w)."""
    cv2 = opencv()
    made = np.full(masks.shape, NOWHERE, np.uint8)
    for t, mask in enumerate(masks):
        if t and np.array_equal(mask, masks[t - 1]):
            made[t] = made[t - 1]
        elif mask.any():
            cv2.distanceTransform((~mask).view(np.uint8), cv2.DIST_L1, 3, dst=made[t], dstType=cv2.CV_8U)
    return made


@dataclass(frozen=True)
class Found:
    """What is found in frames: the masks (objects, n) and the points (objects, n, 3, 2) of objects.

    `last` is where each object was last (px).
    """

    bits: Bits
    points: Array
    last: dict[int, NDArray[np.float64]]

    @classmethod
    def of(cls, masks: Mask) -> Found:
        """Return what has the given masks (objects, n, h, w)."""
        count, frames = masks.shape[:2]
        points = [mask_points(mask) if mask.any() else np.full((3, 2), np.nan) for whole in masks for mask in whole]
        return cls(packed(masks), np.reshape(points, (count, frames, 3, 2)), {})

    def copy(self) -> Found:
        """Return a copy that can change."""
        return Found(self.bits.copy(), self.points.copy(), dict(self.last))

    def add(self, k: int, t: int, mask: Mask, box: tuple[slice, slice], shape: tuple[int, ...]) -> None:
        """Add the mask of an object in a `box` of a frame (h, w)."""
        whole = np.zeros(shape, bool)
        whole[box] = mask
        self.bits[k, t] = packed(whole)
        self.points[k, t] = mask_points(mask) + np.array([box[1].start, box[0].start])

    def take(self, other: Found, k: int, t: int) -> None:
        """Take an object of a frame from what is found for another future."""
        self.bits[k, t], self.points[k, t] = other.bits[k, t], other.points[k, t]
        if k in other.last:
            self.last[k] = other.last[k]


class Segmenter:
    """Finds objects by their palettes, given the background. `widths` are those of the objects (px)."""

    def __init__(
        self, plate: NDArray[np.uint8], palettes: Mapping[int, Palette], objects: Sequence[int], widths: Array
    ) -> None:
        self._objects, self._widths = objects, widths
        self._palettes = {body: colours for body, colours in palettes.items() if body in objects}
        others = {body: colours for body, colours in palettes.items() if body not in objects}
        self._palettes |= {body: colours for body, colours in others.items() if self._is_other(colours)}
        self._ground = lab(smooth(plate))
        plain = self._ground.reshape(-1, 3)
        self._near = {
            body: np.stack([np.minimum(MAX_COLOUR, NEARER * _away(plain, colour)) for colour in colours])
            for body, colours in self._palettes.items()
        }

    def _is_other(self, colours: Palette) -> bool:
        """Whether colours are unlike those of every object; equal ones would take the object's pixels."""
        own = [colour for body in self._objects if body in self._palettes for colour in self._palettes[body]]
        return all(float(_weighted((a - b)[None], PALETTE_LIGHTNESS)[0]) > MIN_FOREGROUND for a in colours for b in own)

    def masks(
        self,
        frames: Frames,
        valid: Mask,
        background: Mask,
        places: Array,
        expected: Callable[[], Sequence[NDArray[np.uint8]]],
    ) -> tuple[list[Found], Mask]:
        """Return the objects in frames, and the pixels (n, h, w) that differ from the background.

        `valid` (h, w) are the pixels that the frames show, `background` those in which nothing moves in any future.
        `places` (objects, 2) px are where each object is before the first frame, NaN if that is unknown. `expected`
        returns how far each object is from each pixel (objects, n, h, w) in each future, see `distances_from`. The
        objects are found for each of these, or once if all are equal.
        """
        differs = np.zeros(frames.shape[:3], bool)
        ground = np.where(background[..., None], _median(frames), self._ground)
        threshold, quiet = MIN_FOREGROUND, background & valid
        last = {k: place for k, place in enumerate(places) if not np.isnan(place).any()}
        count = len(self._objects), len(frames)
        found = [Found(np.stack([packed(differs)] * count[0]), np.full((*count, 3, 2), np.nan), last)]
        for t, frame in enumerate(frames):
            picture = lab(smooth(frame))
            away = _weighted(picture - ground, PLATE_LIGHTNESS)
            if t == 0 and quiet.any():
                threshold = max(threshold, float(np.quantile(away[quiet], _QUIET)))
            differs[t] = (away > threshold) & valid
            where = np.flatnonzero(differs[t])
            pixels = picture.reshape(-1, 3)[where]
            gaps = {body: self._gaps(pixels, where, body) for body in self._palettes}
            nearest = np.minimum.reduce([np.full(len(where), np.inf, np.float32), *gaps.values()])
            own = {
                k: (gaps[body] <= nearest + EQUAL_COLOUR) & (gaps[body] < np.inf)
                for k, body in enumerate(self._objects)
                if body in gaps
            }
            shared = np.sum(list(own.values()), axis=0) > 1 if own else np.zeros(len(where), bool)
            divided = np.count_nonzero(shared) >= MIN_SHARED
            if divided and len(found) < len(expected()):
                found = [found[0].copy() for _ in expected()]
            known: dict[tuple[int, bytes, bytes], Found] = {}
            for number, one in enumerate(found):
                mine = self._divided(own, where, shared, expected()[number][:, t]) if divided else own
                for k, which in mine.items():
                    # Most futures expect the same, and what is found for one is found for another.
                    key = k, which.tobytes(), one.last[k].tobytes() if k in one.last else b""
                    if key in known:
                        one.take(known[key], k, t)
                        continue
                    mask = np.zeros(valid.shape, np.uint8)
                    mask.ravel()[where[which]] = 1
                    part = self._component(mask, k, one.last)
                    if part is not None:
                        one.add(k, t, *part, mask.shape)
                    known[key] = one
        return found, differs

    def _divided(
        self, own: Mapping[int, Mask], where: NDArray[np.intp], shared: Mask, away: NDArray[np.uint8]
    ) -> Mapping[int, Mask]:
        """Leave each of the `shared` pixels `where` to the object of those that `own` it which is expected nearest.

        `away` (objects, h, w) is how far each object is expected from each pixel.
        """
        gaps = {k: np.where(which[shared], away[k].ravel()[where[shared]], NOWHERE) for k, which in own.items()}
        least = np.minimum.reduce(list(gaps.values()))
        made = {k: which.copy() for k, which in own.items()}
        for k, which in made.items():
            which[shared] &= gaps[k] <= least
        return made

    def _gaps(self, pixels: NDArray[np.float32], where: NDArray[np.intp], body: int) -> NDArray[np.float32]:
        """Return the distance of pixels (n, 3) at places `where` from a body's nearest colour that they may have.

        A pixel has a colour if it is clearly nearer to that than the background is; infinite if it has none.
        """
        gaps = np.stack([_away(pixels, colour) for colour in self._palettes[body]])
        gaps[gaps >= self._near[body][:, where]] = np.inf
        return np.asarray(gaps.min(axis=0))

    def _component(
        self, mask: NDArray[np.uint8], k: int, last: dict[int, NDArray[np.float64]]
    ) -> tuple[Mask, tuple[slice, slice]] | None:
        """Return the largest part of a mask, rather one near the object's last place, with what lies around it.

        The result is a mask in a box; None if there is no such part.
        """
        cv2 = opencv()
        left, top, across, down = cv2.boundingRect(mask)
        if not across:
            return None
        box = slice(max(top - 1, 0), top + down + 1), slice(max(left - 1, 0), left + across + 1)
        opened = cv2.morphologyEx(mask[box], cv2.MORPH_OPEN, np.ones((2, 2), np.uint8))
        count, labels, stats, centres = cv2.connectedComponentsWithStats(opened, connectivity=8)
        width = self._widths[k]
        if count < 2:
            return None
        areas, centres = stats[1:, 4].astype(float), centres[1:] + np.array([box[1].start, box[0].start])
        weights = areas
        if k in last:
            weights = areas * np.exp(-np.hypot(*(centres - last[k]).T) / MEMORY)
        best = int(np.argmax(weights))
        if areas[best] < max(8.0, MIN_AREA * width**2):
            return None
        last[k] = centres[best]
        near = (np.hypot(*(centres - centres[best]).T) < REACH * width) & (areas >= 6)
        return np.concatenate(([False], near))[labels], box


def _median(frames: Frames) -> NDArray[np.float32]:
    """Return the median (h, w, 3), Lab, of some frames.

    Static parts of the scene remain in it, in the colours of the clip: a model may change those of single objects.
    """
    chosen = np.linspace(0, len(frames) - 1, min(_MEDIAN_OF, len(frames))).round().astype(int)
    levels = [smooth(frames[t]) for t in chosen]
    # Sorting whole pictures by neighbours is faster than sorting each pixel.
    for step in range(len(levels)):
        for i in range(step % 2, len(levels) - 1, 2):
            levels[i], levels[i + 1] = np.minimum(levels[i], levels[i + 1]), np.maximum(levels[i], levels[i + 1])
    low, high = levels[(len(levels) - 1) // 2], levels[len(levels) // 2]
    return lab(low if len(levels) % 2 else ((low.astype(np.uint16) + high) // 2).astype(np.uint8))


#: Frames of which the median is taken; share of the background that may differ from it by noise.
_MEDIAN_OF, _QUIET = 7, 0.98
