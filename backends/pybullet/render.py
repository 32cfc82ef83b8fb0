"""The parity look in PyBullet's TinyRenderer (CPU, no OpenGL)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmspec.core.diagnostics import WmsError
from wmspec.core.native_output import silence
from wmspec.sim.scene.model import Array, Camera, Frame, Geom, Pose, Scene, Shot
from wmspec.sim.scene.model.transform import apply, compose, inverse
from wmspec.sim.scene.render.camera import projection_matrix, view_matrix, world_camera
from wmspec.sim.scene.render.color import round_up_color
from wmspec.sim.scene.render.contact_shadow import ContactShadows, stacked
from wmspec.sim.scene.render.near_plane import NearPlane
from wmspec.sim.scene.render.picture import Image, halve, quantize, require_all_poses
from wmspec.sim.scene.render.shadow import SUN_SHADE, ShadowCasters
from wmspec.sim.scene.render.texcoords import texcoords
from wmspec.sim.shapes.facets import Facets

from .images import Pattern, TextureCache
from .shadow import Sun
from .triangles import shared_lists, split_by_plane

with silence():
    import pybullet

SHADOW_MAP_SCALE = 1.5
"""Side of the shadow map relative to the picture."""

WHITE = 255
"""TinyRenderer's background."""

HIDDEN_POSITION = [0.0, 0.0, 1e6]
"""Hidden bodies are moved here; drawing them would take most of the time."""


@dataclass(frozen=True)
class DepthLayer:
    """TinyRenderer output: `rgba` (h, w, 4), `depth` (h, w) 0..1, PyBullet's `numbers` (h, w), -1 for none."""

    rgba: NDArray[np.uint8]
    depth: NDArray[np.float32]
    numbers: NDArray[np.int32]

    @classmethod
    def of(cls, image: Sequence[Any]) -> DepthLayer:
        """Return the layer of a `getCameraImage` result: arrays, or flat tuples if PyBullet was built without NumPy."""
        width, height, rgba, depth, numbers = image
        return cls(
            np.asarray(rgba, np.uint8).reshape(height, width, 4),
            np.asarray(depth, np.float32).reshape(height, width),
            np.asarray(numbers, np.int32).reshape(height, width),
        )

    def over(self, other: DepthLayer) -> DepthLayer:
        """Return the nearer of both at every pixel, equal to drawing both at once."""
        near = (self.numbers >= 0) & (self.depth < other.depth)
        whole = np.where(near, self.rgba.view(np.uint32)[..., 0], other.rgba.view(np.uint32)[..., 0])
        return DepthLayer(
            whole[..., None].view(np.uint8),
            np.where(near, self.depth, other.depth),
            np.where(near, self.numbers, other.numbers),
        )


@dataclass(frozen=True)
class DrawnGeom:
    """A geom of a body; its sides are PyBullet bodies `numbers` with `planes` (n, 4)."""

    body: int
    geom: int
    pose: Pose
    numbers: tuple[int, ...]
    planes: Array
    pattern: Pattern | None


class Renderer:
    """Draws one scene: every side of a visible geom is a massless body of its own client."""

    def __init__(self, scene: Scene, width: int, height: int) -> None:
        self._scene, self._size = scene, (width, height)
        self._casters, self._contact = ShadowCasters(scene), ContactShadows(scene)
        self._near = NearPlane(scene, width / height)
        self._client = pybullet.connect(pybullet.DIRECT)
        # front to back, so that hidden pixels are not shaded
        order = sorted(range(len(scene.bodies)), key=self._casters.size)
        shown = [(i, j, geom) for i in order for j, geom in enumerate(scene.bodies[i].geoms) if geom.visible]
        self._images = TextureCache(self._client)
        self._pieces = [DrawnGeom(i, j, geom.pose, *_add(geom, self._images, self._client)) for i, j, geom in shown]
        self._halved: dict[int, int] = {}
        self._owner = np.full(pybullet.getNumBodies(self._client) + 1, -1, np.int16)
        for piece in self._pieces:
            self._owner[list(piece.numbers)] = piece.body
        self._moves = np.array([body.motion != "static" for body in scene.bodies], dtype=bool)
        self._still: dict[str, tuple[bytes, DepthLayer, DepthLayer]] = {}

    def draw(self, shot: Shot, *, depth: bool = False) -> Frame:
        """Draw the bodies at the poses of the shot."""
        require_all_poses(self._scene, shot)
        camera = world_camera(self._scene, shot)
        near = self._near.before(camera, shot)
        fine, coarse = self._layers(near, shot)
        lit, dark = self._smooth(fine), coarse.rgba[..., :3] + np.float32(0.5)
        ids, distance = self._owner[coarse.numbers], _metres(coarse.depth, near)
        distance[ids < 0] = 0
        shaded = np.float32(SUN_SHADE) * self._occlusion(camera, shot, distance)
        rgb = quantize(lit - shaded[..., None] * np.maximum(lit - dark, 0))
        return Frame(self._contact.cast(rgb, ids, distance, camera, shot), ids, distance if depth else None)

    def repaint(self, scene: Scene) -> bool:
        """Switch to a scene that differs in colours only."""
        self._scene = scene
        self._still.clear()
        for piece in self._pieces:
            color = _rgba(scene.bodies[piece.body].geoms[piece.geom])
            for number in piece.numbers:
                pybullet.changeVisualShape(number, -1, rgbaColor=color, physicsClientId=self._client)
        return True

    def close(self) -> None:
        """Free the client."""
        pybullet.disconnect(self._client)

    def _layers(self, camera: Camera, shot: Shot) -> tuple[DepthLayer, DepthLayer]:
        """Return the shot at twice its size, and at its size in ambient light; both without shadows."""
        resting = [camera.pose, *(pose for pose, moves in zip(shot.poses, self._moves, strict=True) if not moves)]
        still = np.float64(camera.near).tobytes()  # depths are comparable only with equal near planes
        still += b"".join(pose.position.tobytes() + pose.orientation.tobytes() for pose in resting)
        if camera.name not in self._still or self._still[camera.name][0] != still:
            self._still[camera.name] = (still, *self._pair(camera, shot.poses, ~self._moves))
        _, fine, coarse = self._still[camera.name]
        moving = self._pair(camera, shot.poses, self._moves)
        return moving[0].over(fine), moving[1].over(coarse)

    def _pair(self, camera: Camera, poses: Sequence[Pose], shown: NDArray[np.bool_]) -> tuple[DepthLayer, DepthLayer]:
        (width, height), light = self._size, self._scene.light
        self._place(poses, camera, shown)
        self._dress(poses, camera, shown)
        fine = self._draw(camera, (2 * width, 2 * height), light.ambient, light.diffuse)
        return fine, self._draw(camera, (width, height), light.ambient, 0.0)

    def _place(self, poses: Sequence[Pose], camera: Camera, shown: NDArray[np.bool_]) -> None:
        """Place visible sides of the bodies `shown`, and hide all others."""
        for piece in self._pieces:
            for number in () if shown[piece.body] else piece.numbers:
                pybullet.resetBasePositionAndOrientation(number, HIDDEN_POSITION, [0, 0, 0, 1], self._client)
        for piece, pose, eye in self._seen(poses, camera, shown):
            w, *turn = pose.orientation.tolist()
            at = pose.position.tolist()
            for number, faces in zip(piece.numbers, piece.planes @ np.append(eye, 1.0) > 0, strict=True):
                place = at if faces else HIDDEN_POSITION
                pybullet.resetBasePositionAndOrientation(number, place, [*turn, w], self._client)

    def _dress(self, poses: Sequence[Pose], camera: Camera, shown: NDArray[np.bool_]) -> None:
        """Assign textures whose texels match the pixels to the sides of the bodies `shown`."""
        pixel = 2 * math.tan(camera.fovy / 2) / self._size[1]
        for piece, _, eye in self._seen(poses, camera, shown):
            if piece.pattern is None:
                continue
            for number, halvings in zip(piece.numbers, piece.pattern.halvings(eye, pixel), strict=True):
                if self._halved.get(number, 0) != halvings:
                    image = self._images.number(piece.pattern.file, halvings)
                    pybullet.changeVisualShape(number, -1, textureUniqueId=image, physicsClientId=self._client)
                    self._halved[number] = halvings

    def _seen(
        self, poses: Sequence[Pose], camera: Camera, shown: NDArray[np.bool_]
    ) -> Iterator[tuple[DrawnGeom, Pose, Array]]:
        """Yield the geoms of the bodies `shown`, their world poses, and the camera (3,) in their frames."""
        pieces = [piece for piece in self._pieces if shown[piece.body]]
        if not pieces:
            return
        every = compose(stacked([poses[piece.body] for piece in pieces]), stacked([piece.pose for piece in pieces]))
        eyes = apply(inverse(every), camera.pose.position)
        for i, piece in enumerate(pieces):
            yield piece, Pose(every.position[i], every.orientation[i]), eyes[i]

    def _smooth(self, fine: DepthLayer) -> Image:
        """Return colours 0..255 (h, w, 3), the mean of four samples, over the background."""
        empty, sky = halve(fine.numbers < 0), np.rint(255 * np.asarray(self._scene.background)).astype(np.float32)
        # TinyRenderer truncates bytes: half a byte is missing on average
        mean: Image = halve(fine.rgba)[..., :3] + np.float32(0.5)
        mean += empty[..., None] * (sky - np.float32(WHITE + 0.5))
        return mean

    def _occlusion(self, camera: Camera, shot: Shot, depth: NDArray[np.float32]) -> Image:
        """Return the shadowed fraction, 0..1, of each point at `depth` (h, w)."""
        if not self._scene.light.shadows:
            return np.zeros_like(depth)
        region = self._casters.region(camera, shot)
        sun, side = Sun(region, self._scene.light.direction), round(SHADOW_MAP_SCALE * max(self._size))
        self._place(shot.poses, sun.camera, region.casts)
        sight = self._draw(sun.camera, (side, side), 1.0, 0.0)
        seen = np.where(sight.numbers < 0, np.float32(np.inf), _metres(sight.depth, sun.camera))
        return sun.occlusion(camera, depth, seen)

    def _draw(self, camera: Camera, size: tuple[int, int], ambient: float, diffuse: float) -> DepthLayer:
        """Draw the placed bodies."""
        width, height = size
        projection = projection_matrix(camera, width / height)
        # TinyRenderer samples pixel corners, not centres
        projection[0, 2] += 1 / width
        projection[1, 2] += 1 / height
        image = pybullet.getCameraImage(
            width,
            height,
            view_matrix(camera.pose).T.ravel().tolist(),
            projection.T.ravel().tolist(),
            lightDirection=(-self._scene.light.direction).tolist(),
            lightColor=[1, 1, 1],
            lightDistance=1,
            lightAmbientCoeff=ambient,
            lightDiffuseCoeff=diffuse,
            lightSpecularCoeff=0,
            shadow=0,
            renderer=pybullet.ER_TINY_RENDERER,
            physicsClientId=self._client,
        )
        return DepthLayer.of(image)


def _metres(z: NDArray[np.float32], camera: Camera) -> NDArray[np.float32]:
    """Return metres for OpenGL depths 0..1."""
    near, far = camera.near, camera.far
    return (far * near / (far - (far - near) * z.astype(np.float64))).astype(np.float32)


def _add(geom: Geom, images: TextureCache, client: int) -> tuple[tuple[int, ...], Array, Pattern | None]:
    """Add the sides of a geom; return PyBullet ids, planes and pattern."""
    look = geom.surface
    facets, every = zip(*split_by_plane(texcoords(geom)), strict=True)
    planes, bodies = np.stack(every), tuple(_side(geom, one, client) for one in facets)
    for body in bodies if look.texture else ():
        number = images.number(look.texture or "", None if look.repeats is None else 0)
        pybullet.changeVisualShape(body, -1, textureUniqueId=number, physicsClientId=client)
    return bodies, planes, Pattern.of(geom, facets, planes)


def _rgba(geom: Geom) -> list[float]:
    return [*round_up_color(geom.surface.color), 1.0]


def _side(geom: Geom, facets: Facets, client: int) -> int:
    with shared_lists(facets) as mesh:
        shape = pybullet.createVisualShape(
            pybullet.GEOM_MESH, rgbaColor=_rgba(geom), specularColor=[0, 0, 0], physicsClientId=client, **mesh
        )
    if shape < 0:
        raise WmsError(f"PyBullet cannot draw '{geom.name}'; expected a mesh of fewer than 131072 vertices")
    return int(pybullet.createMultiBody(baseVisualShapeIndex=shape, physicsClientId=client))
