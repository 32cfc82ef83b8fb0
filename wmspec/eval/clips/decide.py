"""Decides which future a clip shows, or for what reasons it shows none of them.

No threshold is fitted to clips of models. For a distance that obeys the triangle inequality, a clip that is less than
half as far from its nearest future as that is from its nearest rival can have no other nearest future.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from wmspec.dataset.film.distances import END_FRAMES, Array, end_distance, film_distance, point_distance
from wmspec.eval.clips.measure import Measurement
from wmspec.eval.clips.normalise import MAX_ZOOM, MIN_INLIERS

#: Largest ratio of the distance to the nearest future and that of this future to its nearest rival.
MAX_RATIO = 0.5
#: Largest share of frames in which an object is there in the clip and not in the future, or the other way round.
MAX_MISSING = 1 / 3
#: Largest share of the frames after the end of the clip.
MAX_SHORT = 0.1
#: A clip moves nowhere if this share of the weighted motion of every future is missing.
FROZEN = 0.95
#: Of three comparisons by pixels, as many must choose the same future, each by being nearer than this share of its
#: distance to the next; a mixture of two futures is as near to both. At another tempo, one must choose it, if barely.
MIN_VOTES, VOTE_MARGIN = 2, 0.85
#: A rival counts as elsewhere if the chosen future leaves this share of its place empty; it is a ghost if the clip
#: leaves less than half of that empty.
VACANT = 0.2
#: Tempos (clip time runs slower or faster by these factors) and delays (s) that are tried.
TEMPOS = tuple(round(0.7 + 0.05 * i, 2) for i in range(15))
DELAYS = (0.0, 0.1, 0.2, 0.3)

#: The reasons to abstain.
REASONS = {
    "distance": "it is not much nearer to one future than that is to another",
    "end": "its end is not much nearer to one future than that is to another",
    "missing": "an object vanishes or appears",
    "frozen": "nothing moves where the futures move",
    "vote": "pixels do not confirm the future that the objects choose",
    "ghost": "objects are in the places of two futures at once",
    "camera": "the camera moves too far to be followed",
    "short": "it ends before the time of the answer",
}


@dataclass(frozen=True)
class Decision:
    """The chosen option (None: none of them, for the reasons in `why`), and what the choice is based on.

    `distances` (k) and `ratio` are those at the chosen tempo. `nearest` is the forced choice.
    """

    choice: int | None
    nearest: int
    why: tuple[str, ...]
    distances: tuple[float, ...]
    ratio: float
    end_ratio: float
    margin: float
    tempo: float
    delay: float
    missing: float


def decide(measured: Measurement, rate: int) -> Decision:
    """Return the decision on a measured clip; `rate` is that of the films (Hz)."""
    plain = _at_tempo(measured, 1.0, 0.0, rate)
    if "distance" in plain.why or "end" in plain.why:
        return _best_tempo(measured, rate) or plain
    return plain


def _best_tempo(measured: Measurement, rate: int) -> Decision | None:
    """Return the decision at the tempo at which some future is nearest, if that future is clear at every tempo."""
    tried = list(product(TEMPOS, DELAYS))
    table = np.array([_warped(measured, tempo, delay, rate) for tempo, delay in tried])
    row, nearest = np.unravel_index(int(np.argmin(table)), table.shape)
    rivals = np.delete(table.min(axis=0), nearest)
    decision = _at_tempo(measured, *tried[row], rate)
    clear = table[row, nearest] <= MAX_RATIO * rivals.min()
    return decision if clear and decision.choice == int(nearest) else None


def _warped(measured: Measurement, tempo: float, delay: float, rate: int) -> Array:
    """Return the distances to all futures at one tempo and delay."""
    points, kept = _clip_points(measured, tempo, delay, rate)
    distances = np.full(len(measured.futures), np.inf)
    for o in range(len(measured.futures)):
        future = _futures(measured, o, tempo, delay, rate)
        # A clip that ends before an object comes out, or goes in, does not show it.
        if (np.isnan(future[:, -1, 0, 0]) == np.isnan(measured.futures[o, :, -1, 0, 0])).all():
            distances[o] = film_distance(points[o], future[:, kept], measured.widths)
    return distances


def _clip_points(measured: Measurement, tempo: float, delay: float, rate: int) -> tuple[Array, slice]:
    """Return the frames of the clip for which the futures are known at a tempo and delay."""
    count = measured.points.shape[2]
    last = int(min(count, np.floor(count / tempo + delay * rate + 1e-9)))
    return measured.points[:, :, :last], slice(0, last)


def _futures(measured: Measurement, option: int, tempo: float, delay: float, rate: int) -> Array:
    """Return the points of a future as a clip shows them that runs at a tempo, after a delay (s)."""
    future: Array = measured.futures[option]
    if tempo == 1.0 and delay == 0.0:
        return future
    count = future.shape[1]
    times = np.clip((np.arange(1, count + 1) - delay * rate) * tempo - 1, 0, count - 1)
    low = np.floor(times).astype(int)
    high, part = np.minimum(low + 1, count - 1), (times - low)[None, :, None, None]
    mixed: Array = (1 - part) * future[:, low] + part * future[:, high]
    return np.asarray(np.where(np.isnan(mixed), future[:, np.rint(times).astype(int)], mixed))


def _at_tempo(measured: Measurement, tempo: float, delay: float, rate: int) -> Decision:
    """Return the decision at one tempo and delay."""
    points, kept = _clip_points(measured, tempo, delay, rate)
    options = range(len(measured.futures))
    whole = [_futures(measured, o, tempo, delay, rate) for o in options]
    futures = [future[:, kept] for future in whole]
    widths = measured.widths
    distances = np.array([film_distance(*pair, widths) for pair in zip(points, futures, strict=True)])
    nearest = int(np.argmin(distances))
    rivals = [o for o in options if o != nearest]
    rival = min(min(film_distance(futures[nearest], futures[o], widths), measured.apart[0, nearest, o]) for o in rivals)
    ends = min(min(end_distance(futures[nearest], futures[o], widths), measured.apart[1, nearest, o]) for o in rivals)
    ratio = float(distances[nearest]) / max(rival, 1e-9)
    end_ratio = end_distance(points[nearest], futures[nearest], widths) / max(ends, 1e-9)
    ordered = np.sort(distances)
    missing = _missing(measured.points[nearest], whole[nearest])
    why = [
        name
        for name, holds in (
            ("short", measured.short > MAX_SHORT),
            ("camera", measured.zoom > MAX_ZOOM or measured.inliers < MIN_INLIERS),
            ("frozen", float(measured.physics_iq[:, 2].max()) < 1 - FROZEN),
            ("distance", ratio > MAX_RATIO),
            ("end", end_ratio > MAX_RATIO),
            ("missing", missing > MAX_MISSING),
            ("vote", not _confirmed(measured, nearest, real_time=tempo == 1.0 and delay == 0.0)),
            ("ghost", _ghost(measured, nearest)),
        )
        if holds
    ]
    return Decision(
        choice=None if why else nearest,
        nearest=nearest,
        why=tuple(why),
        distances=tuple(float(d) for d in distances),
        ratio=ratio,
        end_ratio=float(end_ratio),
        margin=float((ordered[1] - ordered[0]) / max(ordered[1], 1e-9)),
        tempo=tempo,
        delay=delay,
        missing=missing,
    )


def _missing(points: Array, future: Array) -> float:
    """Return the share of frames in which an object is there in one and not in the other, of the worst object.

    It is 1 if the two differ in all of the last frames, from the one on in which an object comes out or goes in.
    """
    absent = np.isnan(future[..., 0, 0])
    gone = np.isnan(points[..., 0, 0]) != absent
    last = absent[:, -END_FRAMES:] == absent[:, -1:]
    ends = np.logical_and.accumulate(last[:, ::-1], axis=1)[:, ::-1]
    if (gone[:, -END_FRAMES:] | ~ends).all(axis=1).any():
        return 1.0
    return float(gone.mean(axis=1).max())


def _confirmed(measured: Measurement, option: int, *, real_time: bool) -> bool:
    """Whether enough comparisons by pixels, which are made in real time, choose an option."""
    others = np.delete(measured.votes, option, axis=1).min(axis=1)
    if real_time:
        return int((measured.votes[:, option] <= VOTE_MARGIN * others).sum()) >= MIN_VOTES
    return bool((measured.votes[:, option] < others).any())


def _ghost(measured: Measurement, option: int) -> bool:
    """Whether the clip also fills the place of a future that the chosen one leaves empty."""
    empty = measured.vacancies[option]
    others = [o for o in range(len(empty)) if o != option and empty[o] > VACANT]
    return any(float(measured.left_empty[o]) < 0.5 * float(empty[o]) for o in others)


def track_error(points: Array, truth: Array, widths: Array) -> tuple[float, float]:
    """Return the mean distance of all objects from the truth over the way and at the end, in widths."""
    gaps = point_distance(points, truth, widths)
    return float(gaps.mean()), float(gaps[:, -END_FRAMES:].mean())
