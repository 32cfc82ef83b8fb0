"""Visibility of a body in pictures: size, occlusion, contrast."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from wmspec.core.memoize import cached_on
from wmspec.runtime.questions.difference import ciede2000, lab, lab_of_bytes
from wmspec.runtime.questions.observed import Observed
from wmspec.runtime.questions.patch import patch
from wmspec.runtime.questions.silhouette import Silhouette, box, silhouette
from wmspec.runtime.questions.views import View
from wmspec.sim.scene.model import Frame
from wmspec.sim.scene.render.appearance import vanished_bodies

#: Width of the surround of a body, relative to the picture.
SURROUND_WIDTH = 3 / 256


def visible(observed: Observed, name: str, camera: str) -> float:
    """Return the smallest share of the picture that shows the body, over the views of the camera."""
    return min(_over_views(observed, name, camera, visible_share))


def occluded(observed: Observed, name: str, camera: str) -> float:
    """Return the largest share of the body inside the picture that is occluded, over the views of the camera."""
    return max(_over_views(observed, name, camera, hidden_share))


def contrast(observed: Observed, name: str, camera: str) -> float:
    """Return the smallest colour difference (CIEDE2000) to the surround, over the views of the camera; 0 if not
    visible.
    """
    return min(_over_views(observed, name, camera, lambda o, i, view: surround_contrast(o.picture(*view), i)))


def _over_views(
    observed: Observed, name: str, camera: str, measure: Callable[[Observed, int, View], float]
) -> list[float]:
    index = observed.index(name)
    return [measure(observed, index, view) for view in observed.views_of(camera)]


def visible_share(observed: Observed, index: int, view: View) -> float:
    """Return the share of a picture that shows a body, 0..1."""
    return patch(observed.picture(*view), index).share


def hidden_share(observed: Observed, index: int, view: View) -> float:
    """Return the occluded share of a body inside the picture, 0..1; 1 if it is outside."""
    whole = outline(observed, index, view).inside
    seen = patch(observed.picture(*view), index).pixels
    return min(max(1 - seen / whole, 0.0), 1.0) if whole > 0 else 1.0


def visible_part(observed: Observed, name: str, view: View) -> float:
    """Return the share of a body that a picture shows, 0..1; 0 if it is hidden, outside, or has vanished."""
    index = observed.index(name)
    if name in vanished_bodies(observed.scene, view[1]):
        return 0.0
    return 1.0 - hidden_share(observed, index, view)


def outline(observed: Observed, index: int, view: View) -> Silhouette:
    """Return the silhouette of a body in a view."""
    camera, time = view
    height, width = observed.picture(camera, time).ids.shape
    return silhouette(observed.scene, index, (camera, observed.poses(time)), (width, height))


def body_in_front(observed: Observed, index: int, view: View) -> str:
    """Return the body that covers most of a body's box in a picture, or ''."""
    camera, time = view
    ids = observed.picture(camera, time).ids
    around = box(observed.scene, index, (camera, observed.poses(time)), (ids.shape[1], ids.shape[0]))
    if around is None:
        return ""
    (left, top), (right, bottom) = np.clip(around, 0, [ids.shape[1], ids.shape[0]]).round().astype(int)
    covered = ids[top : bottom + 1, left : right + 1]
    others = covered[(covered >= 0) & (covered != index)]
    return observed.scene.bodies[int(np.bincount(others).argmax())].name if others.size else ""


def hidden_share_bound(observed: Observed, index: int, view: View) -> float:
    """Return an upper bound of the occluded share of a body; 1 if part of it is outside the picture.

    Unlike `hidden_share` it draws no silhouette; it suffices where much is visible.
    """
    camera, time = view
    frame = observed.picture(camera, time)
    height, width = frame.ids.shape
    around = box(observed.scene, index, (camera, observed.poses(time)), (width, height))
    if around is None or (around < 1).any() or (around > np.array([width, height]) - 1).any():
        return 1.0
    return 1 - patch(frame, index).pixels / float(np.prod(np.ptp(around, axis=0) + 2))


def surround_contrast(frame: Frame, index: int) -> float:
    """Return the mean colour difference (CIEDE2000) between a body and adjacent pixels; 0 if not visible."""
    return cached_on(frame, _outstanding, index)


def _outstanding(frame: Frame, index: int) -> float:
    own = patch(frame, index)
    if not own.pixels:
        return 0.0
    wide = max(1, round(SURROUND_WIDTH * len(frame.ids)))
    (top, bottom), (left, right) = own.rows, own.columns
    near = np.s_[max(top - wide, 0) : bottom + wide + 1, max(left - wide, 0) : right + wide + 1]
    mask, colors = frame.ids[near] == index, frame.rgb[near]
    around = _grown(mask, wide) & ~mask
    if not around.any():
        return 0.0
    return float(ciede2000(lab((colors[mask] / 255.0).mean(axis=0)), lab_of_bytes(colors[around])).mean())


def _grown(mask: NDArray[np.bool_], wide: int) -> NDArray[np.bool_]:
    """Return the mask dilated by a square of `wide` pixels."""
    grown = mask.copy()
    for side in (grown, grown.T):
        near = side.copy()
        for step in range(1, wide + 1):
            side[step:] |= near[:-step]
            side[:-step] |= near[step:]
    return grown
