"""How much two option pictures differ: in places, colours, orientations or outlines."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np

from wmspec.runtime.questions.kinds.kind import OptionImage
from wmspec.runtime.questions.kinds.pictures import PictureAnswer
from wmspec.runtime.questions.legibility.bounds import BOUNDS, entry, ratio
from wmspec.runtime.questions.legibility.color_vision import difference
from wmspec.runtime.questions.legibility.picture_places import center, size
from wmspec.runtime.questions.model import Legibility
from wmspec.runtime.questions.patch import patch
from wmspec.runtime.questions.runs import EnginePair
from wmspec.sim.scene.model import Body, Camera, Frame, Scene, Shot
from wmspec.sim.scene.model.digest import digest
from wmspec.sim.scene.render.appearance import appearance_at
from wmspec.sim.scene.render.camera import world_camera
from wmspec.sim.scene.render.visible_rotation import visible_angle_about


@dataclass(frozen=True)
class _Drawn:
    """An option picture: its run and its frame."""

    image: OptionImage
    frame: Frame

    @cached_property
    def scene(self) -> Scene:
        """The scene as it looks at the time of the picture."""
        return appearance_at(self.image.run.scene, self.image.time)

    @cached_property
    def bodies(self) -> dict[str, tuple[int, Body]]:
        """The index of every body, and the body, by name."""
        return {body.name: (i, body) for i, body in enumerate(self.scene.bodies)}

    @cached_property
    def camera(self) -> Camera:
        """The camera in the world."""
        run = self.image.run
        return world_camera(run.scene, Shot(self.image.camera, run.trace.poses(self.image.time)))

    def size(self, name: str) -> float:
        """Return the drawn size (px) of a body, 0 if it is absent."""
        return size(self.frame, self.bodies[name][0]) if name in self.bodies else 0.0


def option_measures(answer: PictureAnswer, images: Sequence[OptionImage], pair: EnginePair) -> Iterator[Legibility]:
    """Yield the most visible difference of the two options that differ least."""
    drawn = [_Drawn(image, image.run.draw(image.camera, image.time, pair)) for image in images]
    least = [
        max(_differences(answer, (i, j), drawn[i], drawn[j]), key=ratio) for i, j in combinations(range(len(drawn)), 2)
    ]
    if least:
        yield min(least, key=ratio)


def _differences(answer: PictureAnswer, which: tuple[int, int], one: _Drawn, other: _Drawn) -> Iterator[Legibility]:
    """Yield all differences of two option pictures, at least one of them."""
    ridden = not (
        np.allclose(one.camera.pose.position, other.camera.pose.position)
        and np.allclose(one.camera.pose.orientation, other.camera.pose.orientation)
    )
    yield entry("option_place", 0.0)
    for name in dict.fromkeys((*one.bodies, *other.bodies)):
        here, there = one.size(name), other.size(name)
        body = (one.bodies.get(name) or other.bodies[name])[1]
        if (ridden or body.motion != "static") and max(here, there) >= BOUNDS["size"].value:
            yield from _body_differences(answer, which, name, one, other)
    if digest(one.scene.light) != digest(other.scene.light):
        means = [d.frame.rgb.reshape(-1, 3).mean(axis=0) / 255.0 for d in (one, other)]
        yield entry("option_color", difference(*means))


def _body_differences(
    answer: PictureAnswer, which: tuple[int, int], name: str, one: _Drawn, other: _Drawn
) -> Iterator[Legibility]:
    """Yield the differences of a body, drawn in at least one of two pictures."""
    if min(one.size(name), other.size(name)) == 0:
        yield entry("option_place", max(one.size(name), other.size(name)))  # as much as there is of it
        return
    (i, body), (j, twin) = one.bodies[name], other.bodies[name]
    here, there = center(one.frame, i), center(other.frame, j)
    assert here is not None and there is not None  # noqa: PT018
    yield entry("option_place", float(np.linalg.norm(here - there)))
    if name in answer.bodies:
        k = answer.bodies.index(name)
        turns = [answer.outcomes[option, k : k + 1, 3:] for option in which]
        turn = float(np.degrees(visible_angle_about(answer.axes[k], *turns)[0]))
        yield entry("option_turn", 0.0 if np.isnan(turn) else turn)
    if [g.surface for g in body.geoms] != [g.surface for g in twin.geoms]:
        colors = [c for c in (patch(one.frame, i).color, patch(other.frame, j).color) if c is not None]
        yield entry("option_color", difference(*colors))
    if digest(*(g.shape for g in body.geoms)) != digest(*(g.shape for g in twin.geoms)):
        masks = one.frame.ids == i, other.frame.ids == j
        yield entry("option_shape", 1 - float((masks[0] & masks[1]).sum() / (masks[0] | masks[1]).sum()))
