"""Brings a clip into the frame of the films: size, time, colours, and a camera at rest.

Models crop, stretch or add bars, have their own rate, drift in colour and move the camera. None of this is motion of
objects, so it is undone as far as the background allows, and recorded.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from wmspec.dataset.film.codec import Frames
from wmspec.dataset.film.distances import Mask
from wmspec.eval.clips.packages import opencv

Begins = Literal["context", "first", "after"]
Fit = Literal["stretch", "bars", "crop"]

#: Aspects within this ratio are equal.
SAME_ASPECT = 1.02
#: Limits of a camera that can be followed: the zoom, and the share of background points that move alike.
MAX_ZOOM, MIN_INLIERS = 1.35, 0.4
#: Number of background points that the camera and the colours are measured at.
CORNERS, SAMPLES = 200, 1000
#: The camera is followed in this many frames first, and in all of them if it moves.
CAMERA_FRAMES = 9


@dataclass(frozen=True)
class Fitted:
    """A clip in the size of the films: frames (n, h, w, 3), the pixels that it shows (h, w), and how it was fitted."""

    frames: Frames
    valid: Mask
    fit: Fit


def fit_size(frames: Frames, picture: NDArray[np.uint8]) -> Fitted:
    """Return a clip in the size of a known `picture` (h, w, 3): the fit whose first frame is most like it."""
    if frames.shape[1:] == picture.shape:
        return Fitted(frames, np.ones(picture.shape[:2], bool), "stretch")
    choices = _fits(frames.shape[2], frames.shape[1], picture.shape[1], picture.shape[0])
    best = max(choices, key=lambda name: _likeness(*choices[name](frames[0]), picture))
    fitted = [choices[best](frame) for frame in frames]
    return Fitted(np.stack([frame for frame, _ in fitted]), fitted[0][1], best)


def same_aspect(a: tuple[int, int], b: tuple[int, int]) -> bool:
    """Whether two sizes (px) have about the same aspect."""
    return 1 / SAME_ASPECT < a[0] * b[1] / (a[1] * b[0]) < SAME_ASPECT


def _fits(
    width: int, height: int, w: int, h: int
) -> dict[Fit, Callable[[NDArray[np.uint8]], tuple[NDArray[np.uint8], Mask]]]:
    """Return the possible fits of frames (width, height) into (w, h), each with the pixels that it covers."""
    cv2 = opencv()
    whole = np.ones((h, w), bool)

    def stretch(frame: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], Mask]:
        return cv2.resize(frame, (w, h), interpolation=cv2.INTER_AREA), whole

    if same_aspect((width, height), (w, h)):
        return {"stretch": stretch}

    def bars(frame: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], Mask]:
        scale = min(width / w, height / h)
        across, down = round(w * scale), round(h * scale)
        left, top = (width - across) // 2, (height - down) // 2
        inner = np.ascontiguousarray(frame[top : top + down, left : left + across])
        return cv2.resize(inner, (w, h), interpolation=cv2.INTER_AREA), whole

    def crop(frame: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], Mask]:
        scale = max(width / w, height / h)
        across, down = min(w, round(width / scale)), min(h, round(height / scale))
        left, top = (w - across) // 2, (h - down) // 2
        canvas, valid = np.zeros((h, w, 3), np.uint8), np.zeros((h, w), bool)
        canvas[top : top + down, left : left + across] = cv2.resize(frame, (across, down), interpolation=cv2.INTER_AREA)
        valid[top : top + down, left : left + across] = True
        return canvas, valid

    return {"stretch": stretch, "bars": bars, "crop": crop}


def _likeness(frame: NDArray[np.uint8], valid: Mask, picture: NDArray[np.uint8]) -> float:
    """Return the correlation of two pictures, blurred, over the valid pixels."""
    cv2 = opencv()
    a, b = (cv2.GaussianBlur(x, (7, 7), 0).astype(np.float64)[valid] for x in (frame, picture))
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    return float((a * b).sum() / np.sqrt((a**2).sum() * (b**2).sum() + 1e-9))


# ---------------------------------------------------------------- time


def begins_with(
    frames: Frames, times: NDArray[np.float64], context: Frames, nexts: list[NDArray[np.uint8]], rate: int
) -> Begins:
    """Return what a clip begins with: the whole `context`, its last picture, or the frame after it.

    `nexts` are the first frames of the futures. Pictures are compared where the context, or the first step, moves.
    """
    grids = {n: [_grey(frame) for frame in group] for n, group in (("context", context), ("next", nexts))}
    first, last = _grey(frames[0]), grids["context"][-1]
    length = (len(context) - 1) / rate
    moved = _changed(grids["context"], last)
    if len(context) > 1 and moved.any() and times[-1] >= length - 0.5 / rate:
        picked = [_grey(frames[nearest(times, k / rate)]) for k in range(len(context))]
        along = np.mean([_gap(a, b, moved) for a, b in zip(picked, grids["context"], strict=True)])
        if along < 0.7 * _gap(first, last, moved):
            return "context"
    stepped = _changed(grids["next"], last)
    if stepped.any():
        after = min(_gap(first, one, stepped) for one in grids["next"])
        if after < 0.8 * _gap(first, last, stepped):
            return "after"
    return "first"


#: Difference of grey levels (0 to 255) that counts as motion.
_MOVED = 12


def _grey(frame: NDArray[np.uint8]) -> NDArray[np.uint8]:
    cv2 = opencv()
    return np.asarray(cv2.GaussianBlur(cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY), (3, 3), 0), np.uint8)


def _changed(pictures: list[NDArray[np.uint8]], last: NDArray[np.uint8]) -> Mask:
    """Return the pixels (h, w) in which one of the pictures differs from the last one."""
    cv2 = opencv()
    return np.asarray(np.maximum.reduce([cv2.absdiff(picture, last) for picture in pictures]) > _MOVED)


def _gap(a: NDArray[np.uint8], b: NDArray[np.uint8], where: Mask) -> float:
    return float(opencv().absdiff(a, b)[where].mean())


def nearest(times: NDArray[np.float64], time: float) -> int:
    """Return the frame nearest to a time (s)."""
    return int(np.abs(times - time).argmin())


# ---------------------------------------------------------------- colours and camera


def match_colours(frames: Frames, plate: NDArray[np.uint8], background: Mask) -> Frames:
    """Return frames whose background has the colours of the `plate`: one robust line for each channel and frame."""
    cv2 = opencv()
    ys, xs = np.nonzero(background)
    if len(ys) < 50:
        return frames
    chosen = np.random.default_rng(1).choice(len(ys), min(SAMPLES, len(ys)), replace=False)
    where = ys[chosen], xs[chosen]
    known = cv2.blur(plate, (5, 5))[where].T.astype(np.float32)
    seen = np.stack([cv2.blur(frame, (5, 5))[where].T for frame in frames]).astype(np.float32)
    slopes, offsets = _lines(seen, np.broadcast_to(known, seen.shape))
    levels = np.arange(256, dtype=np.float32)[:, None] * slopes[:, None] + offsets[:, None]
    tables = np.clip(levels, 0, 255).astype(np.uint8)[:, None]
    made = np.empty(frames.shape, np.uint8)
    for t, frame in enumerate(frames):
        cv2.LUT(frame, tables[t], dst=made[t])
    return made


def _lines(a: NDArray[np.float32], b: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return slopes and offsets (...) that map `a` to `b` (..., n); the fifth that fits worst is left out.

    `a` is noisy and `b` is not: the line that predicts `a` from `b` is inverted. The other one would be too flat.
    """
    slopes, offsets = _fitted(a, b, np.ones(a.shape, bool))
    gaps = np.abs(b - (slopes[..., None] * a + offsets[..., None]))
    return _fitted(a, b, gaps <= np.quantile(gaps, 0.8, axis=-1)[..., None])


def _fitted(
    a: NDArray[np.float32], b: NDArray[np.float32], keep: Mask
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return slopes and offsets of lines through the points that are kept."""
    number = keep.sum(axis=-1)
    x, y = (np.where(keep, each, 0).astype(np.float64) for each in (a, b))
    x, y = (np.where(keep, each - (each.sum(axis=-1) / number)[..., None], 0) for each in (x, y))
    own, known, both = ((one * other).sum(axis=-1) / (number - 1) for one, other in ((x, x), (y, y), (x, y)))
    clear = (both > 0.5 * np.sqrt(own * known)) & (known > 1)
    slopes = np.where(clear, np.clip(known / np.where(clear, both, 1), 0.4, 2.5), 1).astype(np.float32)
    rests = np.sort(np.where(keep, b - slopes[..., None] * a, np.inf), axis=-1)
    low, high = (np.take_along_axis(rests, (number - k)[..., None] // 2, axis=-1)[..., 0] for k in (1, 0))
    return slopes, np.asarray((low + high) / 2, np.float32)


def match_picture(frames: Frames, first: NDArray[np.uint8], picture: NDArray[np.uint8], valid: Mask) -> Frames:
    """Return frames in the colours of a known `picture` (h, w, 3), which the clip shows as its `first` frame.

    The background alone does not show what became of other colours. Each channel is a polynomial of the three:
    linear and quadratic, fitted with all colours of the picture counting alike.
    """
    cv2 = opencv()
    a, b = (cv2.GaussianBlur(x, (0, 0), 1.5)[::2, ::2][valid[::2, ::2]] for x in (first, picture))
    if len(a) < _MIN_SAMPLES or np.abs(a.astype(np.int16) - b).mean() < _SAME_COLOURS:
        return frames
    coefficients = _polynomial(a.astype(np.float64) / 255, b.astype(np.float64) / 255)
    made = np.empty(frames.shape, np.uint8)
    squares = (np.arange(256, dtype=np.float32) / 255) ** 2
    for t, frame in enumerate(frames):
        linear = cv2.transform(frame.astype(np.float32) / 255, coefficients[:, [0, 1, 2, 6]])
        quadratic = cv2.transform(cv2.LUT(frame, squares), coefficients[:, 3:6])
        made[t] = np.clip((linear + quadratic) * 255, 0, 255)
    return made


#: Fewest pixels that colours are fitted to; mean difference (grey levels) of equal pictures; weight of no change.
_MIN_SAMPLES, _SAME_COLOURS, _RIDGE = 200, 1.5, 0.0003


def _polynomial(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return the coefficients (3, 7) of colours, their squares and 1 that map colours `a` to `b` (n, 3), 0 to 1."""
    _, which, counts = np.unique((b * 7.99).astype(int) @ [1, 8, 64], return_inverse=True, return_counts=True)
    weights = 1 / counts[which.ravel()]
    terms = np.concatenate([a, a**2, np.ones((len(a), 1))], axis=1)
    same = np.eye(7, 3)
    coefficients = same
    keep = np.ones(len(a), bool)
    for _ in range(3):
        x, w = terms[keep], (weights[keep] / weights[keep].sum())[:, None]
        coefficients = np.linalg.solve(x.T @ (w * x) + _RIDGE * np.eye(7), x.T @ (w * b[keep]) + _RIDGE * same)
        gaps = np.abs(b - terms @ coefficients).sum(axis=1)
        keep = gaps <= max(0.1, float(np.quantile(gaps, 0.9)))
    return coefficients.T.astype(np.float32)


@dataclass(frozen=True)
class Steadied:
    """Frames with the camera at rest, and how it moved: the largest zoom, and the share of points that moved alike."""

    frames: Frames
    zoom: float
    inliers: float
    at_rest: bool = True


def steady(frames: Frames, plate: NDArray[np.uint8], background: Mask) -> Steadied:
    """Return frames whose background lies where it lies in the `plate`: a similarity, from points that are tracked."""
    cv2 = opencv()
    still = cv2.cvtColor(plate, cv2.COLOR_RGB2GRAY)
    inner = cv2.erode(background.astype(np.uint8), np.ones((5, 5), np.uint8)) * 255
    points = cv2.goodFeaturesToTrack(still, CORNERS, 0.01, 5, mask=inner)
    if points is None or len(points) < 12:
        return Steadied(frames, 1.0, 1.0)
    points = points.astype(np.float32)
    chosen = np.unique(np.linspace(0, len(frames) - 1, CAMERA_FRAMES).round().astype(int))
    few = _followed(frames[chosen], still, points)
    if few.at_rest:
        return Steadied(frames, 1.0, few.inliers)
    return _followed(frames, still, points)


def _followed(frames: Frames, still: NDArray[np.uint8], points: NDArray[np.float32]) -> Steadied:
    """Return frames with the camera at rest, given points (n, 1, 2) in the grey background `still`."""
    cv2 = opencv()
    made, zooms, shares = [], [1.0], list[float]()
    transform, at_rest = np.eye(2, 3), True
    for frame in frames:
        grey = cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY)
        guess = cv2.transform(points, transform).astype(np.float32)
        flow = {"winSize": (21, 21), "maxLevel": 3, "flags": cv2.OPTFLOW_USE_INITIAL_FLOW}
        found, ok, _ = cv2.calcOpticalFlowPyrLK(still, grey, points, guess, **flow)
        ok = ok[:, 0] > 0
        share = 0.0
        if ok.sum() >= 12:
            estimate, inliers = cv2.estimateAffinePartial2D(points[ok], found[ok], ransacReprojThreshold=1.0)
            share = 0.0 if inliers is None else float(inliers.sum()) / len(points)
            if estimate is not None and share >= MIN_INLIERS:
                transform = estimate
                zooms.append(float(np.hypot(estimate[0, 0], estimate[0, 1])))
        shares.append(share)
        rests = _at_rest(transform)
        at_rest &= rests
        made.append(frame if rests else _undone(frame, transform))
    largest = max(max(zoom, 1 / max(zoom, 1e-6)) for zoom in zooms)
    return Steadied(np.stack(made), largest, float(np.median(shares)), at_rest)


def _at_rest(transform: NDArray[np.float64]) -> bool:
    return bool(np.abs(transform[:, :2] - np.eye(2)).max() < 0.002 and np.abs(transform[:, 2]).max() < 0.4)


def _undone(frame: NDArray[np.uint8], transform: NDArray[np.float64]) -> NDArray[np.uint8]:
    cv2 = opencv()
    size = frame.shape[1], frame.shape[0]
    how = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return np.asarray(cv2.warpAffine(frame, transform, size, flags=how, borderMode=cv2.BORDER_REPLICATE))
