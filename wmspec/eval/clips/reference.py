"""What clips are compared with: the films of a closed set in working size, their background and their objects."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.film.codec import Frames, Ids
from wmspec.dataset.film.distances import END_FRAMES, Array, object_points, widths_of
from wmspec.eval.clips.packages import opencv
from wmspec.eval.clips.pixels import gradients, motion_masks, thumbnails
from wmspec.eval.clips.segment import Palette, Segmenter, joined, palette, points_of

Mask = NDArray[np.bool_]

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

    `objects` are the bodies, by number in the ids, that tell the futures apart.
    """

    rate: int
    films: tuple[WholeFilm, ...]
    objects: tuple[int, ...]

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
        ids = np.concatenate(every)
        return tuple(body for body in range(int(ids.max()) + 1) if _moves(ids == body))

    def moving_masks(self, option: int) -> Mask:
        """Return where something that moves is seen in the future of an option: (n, h, w)."""
        return np.isin(self._ids[option], self.moving)

    @cached_property
    def background(self) -> Mask:
        """Pixels (h, w) in which nothing that moves is ever seen."""
        seen = [np.isin(film.ids, self.moving).any(axis=0) for film in self.films]
        return np.asarray(~np.any(seen, axis=0))

    @cached_property
    def plate(self) -> NDArray[np.uint8]:
        """The background (h, w, 3): the median of the frames in which it is seen; holes are filled from around."""
        cv2 = opencv()
        step = max(1, len(self.films) * len(self.films[0].frames) // PLATE_FRAMES)
        frames = np.concatenate([film.frames[::step] for film in self.films])
        covered = np.concatenate([np.isin(film.ids[::step], self.moving) for film in self.films])
        levels = frames.astype(np.int16)
        levels[covered] = 999
        ordered = np.sort(levels, axis=0)
        seen = (~covered).sum(axis=0)
        middle = np.take_along_axis(ordered, np.maximum(seen - 1, 0)[None, ..., None] // 2, axis=0)[0]
        holes = (seen == 0).astype(np.uint8)
        plate = np.where(holes[..., None], 0, middle).astype(np.uint8)
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
    def found_masks(self) -> tuple[Mask, ...]:
        """Where the segmenter finds the objects (objects, n, h, w) in each future.

        Clips are compared with these, not with the true masks: what it mistakes in both makes no difference.
        """
        whole = np.ones(self.plate.shape[:2], bool)
        return tuple(
            self.segmenter.masks(future, whole, self.background, self.places(option))[0]
            for option, future in enumerate(self.futures)
        )

    @cached_property
    def found_points(self) -> tuple[Array, ...]:
        """The points (objects, n, 3, 2) where the segmenter finds the objects in each future."""
        return tuple(points_of(masks) for masks in self.found_masks)

    def places(self, option: int) -> Array:
        """Return where each object (n, 2) is in the last frame of a context (px); NaN if it is not seen."""
        film = self.films[option]
        last = film.ids[film.context - 1 : film.context]
        return object_points(last, list(self.objects))[0][:, 0, 0]

    def object_masks(self, option: int) -> Mask:
        """Return the masks (objects, n, h, w) of the objects in a future."""
        return np.stack([self._ids[option] == body for body in self.objects])

    # ------------------------------------------------------------ pixels

    @cached_property
    def thumbnails(self) -> list[Array]:
        """Each future as thumbnails."""
        return [thumbnails(frames) for frames in self.futures]

    @cached_property
    def gradients(self) -> list[Array]:
        """Each future as gradient histograms."""
        return [gradients(frames) for frames in self.futures]

    @cached_property
    def thumbnails_differ(self) -> Mask:
        """Cells of thumbnails in which two futures differ."""
        gaps = [np.abs(a - b).sum(axis=-1) for a, b in combinations(self.thumbnails, 2)]
        return np.asarray(np.max(gaps, axis=0) > THUMBNAIL_GAP)

    @cached_property
    def gradients_differ(self) -> Mask:
        """Cells of gradient histograms in which two futures differ."""
        gaps = [np.linalg.norm(a - b, axis=-1) for a, b in combinations(self.gradients, 2)]
        return np.asarray(np.max(gaps, axis=0) > GRADIENT_GAP)

    @cached_property
    def motion(self) -> list[Mask]:
        """The motion masks of Physics-IQ for each future."""
        return [motion_masks(frames) for frames in self.futures]

    @cached_property
    def vacancies(self) -> Array:
        """Of the place of each future (column), the share that each future (row) leaves empty, over all frames."""
        masks = [self.moving_masks(option) for option in range(len(self.films))]
        return np.array([[_left_empty(there, ~here) for there in masks] for here in masks])

    def left_empty(self, filled: Mask, background: Mask) -> Array:
        """Return, of the place of each future, the share that is not `filled` (n, h, w).

        As much as is filled by chance, in the `background` (h, w), does not count.
        """
        chance = float(filled[:, background].mean()) if background.any() else 0.0
        empty = [_left_empty(self.moving_masks(option), ~filled) for option in range(len(self.films))]
        return np.minimum(np.array(empty) / max(1 - chance, 1e-6), 1.0)


def _left_empty(place: Mask, empty: Mask) -> float:
    return float((place & empty).sum() / max(1, place.sum()))


def _moves(masks: Mask) -> bool:
    areas = masks.sum(axis=(1, 2))
    seen = areas[areas > 0]
    return bool(len(seen)) and float(masks.any(axis=0).sum()) > GROWTH * float(np.median(seen)) + GROWTH_PIXELS


def rivals(palettes: dict[int, Palette], objects: Sequence[int]) -> list[int]:
    """Return the bodies with a palette that are none of the objects."""
    return [body for body in palettes if body not in objects]
