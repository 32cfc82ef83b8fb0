"""Annotations of a picture: names of objects and the paths they have taken."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from PIL import Image, ImageDraw

from wmspec.dataset.build.typeset import font
from wmspec.sim.scene.model import Array, Frame, Scene, Shot, Trace
from wmspec.sim.scene.render.camera import project, world_camera

SUPERSAMPLING = 3
"""Supersampling factor of lines, for smooth edges."""

WAY, HALO, INK = (255, 255, 255), (20, 22, 24), (255, 255, 255)
PATH_STEP = 1 / 60
"""Time step between points of a path (s)."""


def annotate(frame: Frame, scene: Scene, trace: Trace, camera: str, time: float) -> Image.Image:
    """Return the picture with the name of every object that moves or can move, and its path up to `time` (s)."""
    picture = Image.fromarray(frame.rgb)
    width, height = picture.size
    over = Image.new("RGBA", (SUPERSAMPLING * width, SUPERSAMPLING * height))
    draw = ImageDraw.Draw(over)
    shown = [i for i, body in enumerate(scene.bodies) if body.motion != "static"]
    for i in shown:
        for line in _visible_path(scene, trace, camera, i, time, (width, height)):
            points = [(SUPERSAMPLING * x, SUPERSAMPLING * y) for x, y in line.tolist()]
            for color, wide in ((HALO, 4), (WAY, 2)):
                draw.line(
                    points, fill=(*color, 200), width=round(wide * SUPERSAMPLING * height / 512) + 1, joint="curve"
                )
    for i in shown:
        _name(draw, scene.bodies[i].name, frame.ids == i, height)
    small = over.resize(picture.size, Image.Resampling.BOX)
    return Image.alpha_composite(picture.convert("RGBA"), small).convert("RGB")


def _visible_path(
    scene: Scene, trace: Trace, camera: str, body: int, time: float, size: tuple[int, int]
) -> Iterator[Array]:
    """Yield the visible pieces of a body's path in pixels (n, 2); none for a body that barely moved."""
    last = trace.sample(time)
    samples = np.unique(np.append(np.arange(0, last, max(1, round(PATH_STEP / _tick(trace)))), last))
    places = trace.position[samples, body]
    if np.ptp(places, axis=0).max() < 0.005:
        return
    points, depth = project(world_camera(scene, Shot(camera, trace.poses(time))), places, *size)
    before = np.concatenate([[False], depth > 0, [False]])
    begins, ends = np.flatnonzero(~before[:-1] & before[1:]), np.flatnonzero(before[:-1] & ~before[1:])
    for begin, end in zip(begins, ends, strict=True):
        if end - begin > 1:
            yield points[begin:end]


def _tick(trace: Trace) -> float:
    """Return the time step of a trace (s)."""
    return float(trace.time[1] - trace.time[0]) if len(trace.time) > 1 else PATH_STEP


def _name(draw: ImageDraw.ImageDraw, name: str, mask: Array, height: int) -> None:
    """Draw a name above the visible part of a body."""
    rows, columns = np.nonzero(mask)
    if not len(rows):
        return
    size = SUPERSAMPLING * max(9, round(height / 26))
    at = (SUPERSAMPLING * float(columns.min() + columns.max() + 1) / 2, SUPERSAMPLING * float(rows.min()) - size / 5)
    face = font(size, True)
    half = draw.textlength(name, font=face) / 2
    x = min(max(at[0], half), draw.im.size[0] - half)
    y = max(at[1], size * 1.1)
    draw.text((x, y), name, font=face, fill=INK, stroke_width=size // 7, stroke_fill=HALO, anchor="mb")
