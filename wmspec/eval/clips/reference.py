"""What clips are compared with: the films of a closed set in working size, their background and their objects."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.film.codec import Frames, Ids
from wmspec.dataset.film.distances import (
    END_FRAMES,
    Array,
    Mask,
    end_distance,
    film_distance,
    object_points,
    widths_of,
)
from wmspec.eval.clips.packages import opencv
from wmspec.eval.clips.pixels import Bits, Motion, count, difference, gradients, packed, thumbnails
from wmspec.eval.clips.sam2 import Tracker
from wmspec.eval.clips.segment import Found, Palette, Segmenter, distances_from, joined, palette

#: A body moves if the union of its masks is larger than its median mask by this factor, and by these pixels.
GROWTH, GROWTH_PIXELS = 1.15, 4
#: Number of frames from which the background is computed.
PLATE_FRAMES = 24
#: Differences of thumbnails (sum of channels) and of gradient histograms above which films differ in a cell.
THUMBNAIL_GAP, GRADIENT_GAP = 24.0, 0.35


@dataclass(frozen=True)
class WholeFilm:
    """A decoded film in working size: frames (n, h, w, 3), ids (n, h, w), and the number of context frames."""

    frames: Frames
    ids: Ids
    context: int


@dataclass(frozen=True)
class Reference:
    """The films of the options of a question, in order.

    `objects` are the bodies, by number in the ids, that tell the futures apart. A `tracker` finds them in clips and
    futures in the place of the segmenter.
    """

    rate: int
    films: tuple[WholeFilm, ...]
    objects: tuple[int, ...]
    tracker: Tracker | None = None

    @cached_property
    def futures(self) -> tuple[Frames, ...]:
        """The frames after the context, of each option."""
        return tuple(film.frames[film.context :] for film in self.films)

    @cached_property
    def _ids(self) -> tuple[Ids, ...]:
        return tuple(film.ids[film.context :] for film in self.films)

    @property
    def count(self) -> int:
        """The number of frames of the futures."""
        return len(self.futures[0])

    # ------------------------------------------------------------ background

    @cached_property
    def moving(self) -> tuple[int, ...]:
        """The bodies that move in a film, by number."""
        every = [film.ids[:: max(1, len(film.ids) // PLATE_FRAMES)] for film in self.films]
        ids = np.concatenate(every) + 1
        bodies = int(ids.max()) + 1
        areas = np.stack([np.bincount(frame.ravel(), minlength=bodies) for frame in ids])
        ever = np.zeros((bodies, ids[0].size), bool)
        before = np.full_like(ids[0], -1)
        for frame in ids:
            # Most pixels are as in the frame before.
            changed = np.flatnonzero(frame != before)
            ever[frame.ravel()[changed], changed] = True
            before = frame
        unions = ever.sum(axis=1)
        return tuple(body - 1 for body in range(1, bodies) if _moves(areas[:, body], int(unions[body])))

    @cached_property
    def _moving_masks(self) -> tuple[Mask, ...]:
        """Where something that moves is seen in each film (n, h, w)."""
        made = []
        for film in self.films:
            masks = np.zeros(film.ids.shape, bool)
            for body in self.moving:
                masks |= film.ids == body
            made.append(masks)
        return tuple(made)

    @cached_property
    def moving_bits(self) -> Bits:
        """Where something that moves is seen in the future of each option."""
        films = zip(self.films, self._moving_masks, strict=True)
        return np.stack([packed(masks[film.context :]) for film, masks in films])

    @cached_property
    def background(self) -> Mask:
        """Pixels (h, w) in which nothing that moves is ever seen."""
        return np.asarray(~np.any([masks.any(axis=0) for masks in self._moving_masks], axis=0))

    @cached_property
    def plate(self) -> NDArray[np.uint8]:
        """The background (h, w, 3): the median of the frames in which it is seen; holes are filled from around."""
        cv2 = opencv()
        step = max(1, len(self.films) * len(self.films[0].frames) // PLATE_FRAMES)
        frames = np.concatenate([film.frames[::step] for film in self.films])
        covered = np.concatenate([masks[::step] for masks in self._moving_masks])
        plate = frames[0].copy()
        # Most pixels have one colour in all frames.
        varied = (frames.min(axis=0) != frames.max(axis=0)).any(axis=-1) | covered.any(axis=0)
        levels = frames[:, varied].astype(np.int16)
        levels[covered[:, varied]] = 999
        seen = (~covered[:, varied]).sum(axis=0)
        middle = np.take_along_axis(np.sort(levels, axis=0), np.maximum(seen - 1, 0)[None, :, None] // 2, axis=0)[0]
        plate[varied] = np.where(seen[:, None] == 0, 0, middle)
        holes = np.zeros(varied.shape, np.uint8)
        holes[varied] = seen == 0
        return np.asarray(cv2.inpaint(plate, holes, 3, cv2.INPAINT_TELEA) if holes.any() else plate)

    # ------------------------------------------------------------ objects

    @cached_property
    def located(self) -> tuple[tuple[Array, Array], ...]:
        """Points (n, T, 3, 2) and areas (n, T) of the objects in each future (px)."""
        return tuple(object_points(ids, list(self.objects)) for ids in self._ids)

    @cached_property
    def points(self) -> list[Array]:
        """The points of the objects in each future."""
        return [points for points, _ in self.located]

    @cached_property
    def widths(self) -> Array:
        """The width of each object (px)."""
        return widths_of([areas for _, areas in self.located])

    @cached_property
    def palettes(self) -> dict[int, Palette]:
        """The colours of everything that moves, by body; bodies that are hardly seen are left out."""
        # The colours at the end by themselves: an object that is painted there has them in few frames.
        parts = [self._frames(slice(film.context - 1, None, 4) for film in self.films)]
        parts.append(self._frames(slice(-END_FRAMES, None) for _ in self.films))
        made = {
            body: joined([palette(frames, ids == body) for frames, ids in parts])
            for body in dict.fromkeys((*self.objects, *self.moving))
        }
        return {body: colours for body, colours in made.items() if colours is not None}

    def _frames(self, slices: Iterable[slice]) -> tuple[Frames, Ids]:
        """Return some frames of each film, and their ids."""
        chosen = list(zip(self.films, slices, strict=True))
        return (
            np.concatenate([film.frames[which] for film, which in chosen]),
            np.concatenate([film.ids[which] for film, which in chosen]),
        )

    @cached_property
    def segmenter(self) -> Segmenter:
        """Finds the objects in clips."""
        return Segmenter(self.plate, self.palettes, self.objects, self.widths)

    @cached_property
    def _found(self) -> tuple[list[Found], ...]:
        """What is found in each future, for each future that it may be taken for, or once."""
        whole = np.ones(self.plate.shape[:2], bool)
        return tuple(self.find(future, whole, option)[0] for option, future in enumerate(self.futures))

    def find(self, frames: Frames, valid: Mask, option: int) -> tuple[list[Found], Mask]:
        """Return what is found in frames after the context of an option, and what differs from the background.

        See `Segmenter.masks`.
        """
        places, distances = self.places(option), lambda: self._distances
        found, differs = self.segmenter.masks(frames, valid, self.background, places, distances)
        if self.tracker is not None:
            film = self.films[option]
            last = film.context - 1
            masks = np.stack([film.ids[last] == body for body in self.objects])
            found = [Found.of(self.tracker(np.concatenate([film.frames[last : film.context], frames]), masks)[:, 1:])]
        return found, differs

    @cached_property
    def found(self) -> tuple[Found, ...]:
        """What is found in each future.

        Clips are compared with this, not with the true masks: what it mistakes in both makes no difference.
        """
        return tuple(found[min(option, len(found) - 1)] for option, found in enumerate(self._found))

    @cached_property
    def _distances(self) -> tuple[NDArray[np.uint8], ...]:
        """How far each object is from each pixel (objects, n, h, w) in each future."""
        return tuple(np.stack([distances_from(ids == body) for body in self.objects]) for ids in self._ids)

    @cached_property
    def apart(self) -> Array:
        """How far (k, k) each future is from each other one, taken for that: whole distance and that of the end (2)."""
        made = np.zeros((2, len(self.films), len(self.films)))
        for i, found in enumerate(self._found):
            for j, future in enumerate(self.found):
                pair = found[min(j, len(found) - 1)].points, future.points, self.widths
                made[:, i, j] = film_distance(*pair), end_distance(*pair)
        return np.minimum(made, made.transpose(0, 2, 1))

    def places(self, option: int) -> Array:
        """Return where each object (n, 2) is in the last frame of a context (px); NaN if it is not seen."""
        film = self.films[option]
        last = film.ids[film.context - 1 : film.context]
        return object_points(last, list(self.objects))[0][:, 0, 0]

    @cached_property
    def object_bits(self) -> tuple[Bits, ...]:
        """The true masks (objects, n) of the objects in each future."""
        return tuple(np.stack([packed(ids == body) for body in self.objects]) for ids in self._ids)

    # ------------------------------------------------------------ pixels

    @cached_property
    def thumbnails(self) -> list[NDArray[np.int16]]:
        """Each future as thumbnails."""
        return [thumbnails(frames) for frames in self.futures]

    @cached_property
    def gradients(self) -> list[NDArray[np.float32]]:
        """Each future as gradient histograms."""
        return [gradients(frames) for frames in self.futures]

    @cached_property
    def thumbnails_differ(self) -> Mask:
        """Cells of thumbnails in which two futures differ."""
        gaps = [difference(a, b) for a, b in combinations(self.thumbnails, 2)]
        return np.asarray(np.max(gaps, axis=0) > THUMBNAIL_GAP)

    @cached_property
    def gradients_differ(self) -> Mask:
        """Cells of gradient histograms in which two futures differ."""
        gaps = [np.linalg.norm(a - b, axis=-1) for a, b in combinations(self.gradients, 2)]
        return np.asarray(np.max(gaps, axis=0) > GRADIENT_GAP)

    @cached_property
    def motion(self) -> list[Motion]:
        """The motion in each future, as Physics-IQ measures it."""
        return [Motion.of(frames) for frames in self.futures]

    @cached_property
    def vacancies(self) -> Array:
        """Of the place of each future (column), the share that each future (row) leaves empty, over all frames."""
        return np.array([_left_empty(self.moving_bits, here) for here in self.moving_bits])

    def left_empty(self, filled: Mask, background: Mask) -> Array:
        """Return, of the place of each future, the share that is not `filled` (n, h, w).

        As much as is filled by chance, in the `background` (h, w), does not count.
        """
        bits, ground = packed(filled), packed(background)
        chance = float(count(bits & ground).sum() / max(len(filled) * int(count(ground)), 1))
        return np.minimum(_left_empty(self.moving_bits, bits) / max(1 - chance, 1e-6), 1.0)


def _left_empty(places: Bits, filled: Bits) -> Array:
    """Return, of each place (k, n), the share that is not `filled` (n)."""
    return np.asarray(count(places & ~filled).sum(axis=-1) / np.maximum(count(places).sum(axis=-1), 1))


def _moves(areas: NDArray[np.intp], union: int) -> bool:
    """Whether a body moves that has the given areas in frames, and their `union` in all of them (px)."""
    seen = areas[areas > 0]
    return bool(len(seen)) and union > GROWTH * float(np.median(seen)) + GROWTH_PIXELS
