"""Measures a clip: everything about its frames that the decision needs, so that it can be repeated without the clip."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.film.codec import Frames
from wmspec.dataset.film.distances import Array, Mask
from wmspec.eval.clips import normalise
from wmspec.eval.clips.normalise import Begins
from wmspec.eval.clips.pixels import (
    THUMBNAIL,
    Motion,
    count,
    gradient_gap,
    gradients,
    overlaps,
    physics_iq,
    shrink_mask,
    squared_error,
    thumbnail_gap,
    thumbnails,
)
from wmspec.eval.clips.read import Clip
from wmspec.eval.clips.reference import Reference
from wmspec.eval.clips.segment import cleaned

#: Side (cells) of the pictures of gradient histograms.
_GRADIENT_CELLS = 16


@dataclass(frozen=True)
class Measurement:
    """What is measured of a clip, for k options and n objects in T frames after the context.

    `points` (k, n, T, 3, 2) and `areas` (n, T) px are those of the clip, the points once for each future that it may be
    taken for. `futures` (k, n, T, 3, 2) are found likewise in the future of each option, `apart` (2, k, k) are the
    distances of the futures over the way and at the end, `widths` (n) are in px. `votes` (3, k) are the distances by
    gradients, thumbnails and masks. `left_empty` (k) is the share of each option's place that the clip leaves empty,
    `vacancies` (k, k) the share that option i leaves empty of the place of option j. `physics_iq` (k, 4) and `overlap`
    (k) compare with each option. `short` is the share of frames after the end of the clip.
    """

    points: Array
    areas: Array
    futures: Array
    apart: Array
    widths: Array
    votes: Array
    left_empty: Array
    vacancies: Array
    physics_iq: Array
    overlap: Array
    background_rmse: float
    zoom: float
    inliers: float
    short: float
    fit: str
    begins: str

    def arrays(self) -> dict[str, Any]:
        """The values by name, for a file."""
        return {field.name: np.asarray(getattr(self, field.name)) for field in fields(self)}

    @classmethod
    def of(cls, arrays: Mapping[str, Any]) -> Measurement:
        """Return the measurement of `arrays`. Raises KeyError, TypeError or ValueError if it is not one."""
        values: dict[str, Any] = {field.name: np.asarray(arrays[field.name]) for field in fields(cls)}
        values |= {name: str(values[name]) for name in ("fit", "begins")}
        values |= {name: float(values[name]) for name in ("background_rmse", "zoom", "inliers", "short")}
        made = cls(**values)
        made._check()
        return made

    def _check(self) -> None:
        k, n, t = self.futures.shape[:3]
        shapes = {
            "points": (k, n, t, 3, 2), "areas": (n, t), "futures": (k, n, t, 3, 2), "apart": (2, k, k),
            "widths": (n,), "votes": (3, k), "left_empty": (k,), "vacancies": (k, k), "physics_iq": (k, 4),
            "overlap": (k,),
        }  # fmt: skip
        for name, shape in shapes.items():
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} is {getattr(self, name).shape}, expected {shape}")


@dataclass(frozen=True)
class Aligned:
    """The frames (T, h, w, 3) of a clip at the times of the futures, and how it was aligned."""

    frames: Frames
    valid: Mask
    fit: str
    begins: Begins
    short: float


def align(clip: Clip, reference: Reference, truth: int, begins: Begins | None) -> Aligned:
    """Return the frames of a clip after the context of film `truth`, in working size."""
    film, rate = reference.films[truth], reference.rate
    context = film.frames[: film.context]
    fitted = normalise.fit_size(clip.frames, context[-1])
    nexts = [future[0] for future in reference.futures]
    begins = begins or normalise.begins_with(fitted.frames, clip.times, context, nexts, rate)
    delay = {"context": (film.context - 1) / rate, "first": 0.0, "after": -1 / rate}[begins]
    expected = np.arange(1, reference.count + 1) / rate + delay
    picked = [normalise.nearest(clip.times, time) for time in expected]
    frame_time = float(np.median(np.diff(clip.times)))
    late = expected > clip.times[-1] + max(frame_time, 1 / rate)
    first = fitted.frames[normalise.nearest(clip.times, max(delay, 0.0))]
    frames = normalise.match_picture(fitted.frames[picked], first, context[-1], fitted.valid)
    return Aligned(frames, fitted.valid, fitted.fit, begins, float(late.mean()))


def measure(clip: Clip, reference: Reference, truth: int, begins: Begins | None = None) -> Measurement:
    """Return the measurement of a clip; the film `truth` is used for its context alone."""
    aligned = align(clip, reference, truth, begins)
    background = reference.background & aligned.valid
    coloured = normalise.match_colours(aligned.frames, reference.plate, background)
    if not aligned.valid.all():
        # The camera is followed by what surrounds each point, and what a clip does not show is no motion.
        coloured = np.where(aligned.valid[..., None], coloured, reference.plate)
    steadied = normalise.steady(coloured, reference.plate, background)
    frames = steadied.frames
    if frames is not coloured:
        frames = normalise.match_colours(frames, reference.plate, background)
    found, differs = reference.find(frames, aligned.valid, truth)
    options = range(len(reference.films))
    found *= len(options) // len(found)
    motion = Motion.of(frames)
    compared = [physics_iq(motion, reference.motion[o]) for o in options]
    overlap = np.array([overlaps(found[o].bits, reference.object_bits[o]).mean() for o in options])
    likeness = np.array([overlaps(found[o].bits, reference.found[o].bits).mean() for o in options])
    return Measurement(
        points=np.stack([one.points for one in found]),
        areas=np.mean([count(one.bits) for one in found], axis=0),
        futures=np.stack([one.points for one in reference.found]),
        apart=reference.apart,
        widths=reference.widths,
        votes=np.stack([*_pixel_votes(frames, aligned.valid, reference), 1 - likeness]),
        left_empty=reference.left_empty(cleaned(differs), background),
        vacancies=reference.vacancies,
        physics_iq=np.array(compared),
        overlap=overlap,
        background_rmse=_background_rmse(frames, reference.plate, background),
        zoom=steadied.zoom,
        inliers=steadied.inliers,
        short=aligned.short,
        fit=aligned.fit,
        begins=aligned.begins,
    )


def _pixel_votes(frames: Frames, valid: Mask, reference: Reference) -> tuple[Array, Array]:
    """Return the distances (k) by gradient histograms and by thumbnails, in cells where the futures differ."""
    small, edges = thumbnails(frames), gradients(frames)
    cells = reference.thumbnails_differ & shrink_mask(valid, THUMBNAIL)
    places = reference.gradients_differ & shrink_mask(valid, _GRADIENT_CELLS)
    return (
        np.array([gradient_gap(edges, future, places) for future in reference.gradients]),
        np.array([thumbnail_gap(small, future, cells) for future in reference.thumbnails]),
    )


def _background_rmse(frames: Frames, plate: NDArray[np.uint8], background: Mask) -> float:
    """Return the root mean squared error of background pixels, as a share of the range."""
    if not background.any():
        return 0.0
    total = sum(squared_error(frame, plate, background) for frame in frames)
    return float(np.sqrt(total / (3 * len(frames) * np.count_nonzero(background)))) / 255
