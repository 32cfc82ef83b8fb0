"""The parity look in PyBullet's TinyRenderer (on the CPU, no OpenGL)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmspec.backends.pybullet.lists import lists
from wmspec.backends.pybullet.shadow import Sun
from wmspec.backends.pybullet.sides import sides
from wmspec.errors import WmsError
from wmspec.scene.camera import find, projection_matrix, view_matrix
from wmspec.scene.color import texture, whole
from wmspec.scene.model import Array, Camera, Frame, Geom, Pose, Scene, Shot
from wmspec.scene.picture import Image, check, halve, quantize
from wmspec.scene.shadow import SHADE, Casters
from wmspec.scene.silence import silence
from wmspec.scene.tessellate import Facets, tessellate
from wmspec.scene.transform import apply, compose, inverse

with silence():
    import pybullet

TEXELS = 1.5
"""The side of the shadow map, in sides of the picture."""

WHITE = 255
"""TinyRenderer's own background."""

NOWHERE = Pose(np.array([0.0, 0.0, 1e6]), np.array([1.0, 0.0, 0.0, 0.0]))
"""Where ground waits while shadows are drawn: it casts none, but would take most of the time."""


def renderer(scene: Scene, width: int, height: int) -> Renderer:
    """Make a renderer of `width` x `height` pixels."""
    return Renderer(scene, width, height)


@dataclass(frozen=True)
class Piece:
    """A geometry of a body of the scene; every side is a body of PyBullet's by `number`, with its `planes` (n, 4)."""

    body: int
    pose: Pose
    numbers: tuple[int, ...]
    planes: Array


class Renderer:
    """Draws one scene: every side of a visible geometry is a massless body of a client of its own."""

    def __init__(self, scene: Scene, width: int, height: int) -> None:
        self._scene, self._casters, self._size = scene, Casters(scene), (width, height)
        self._client = pybullet.connect(pybullet.DIRECT)
        # what's in front comes first: what's behind it then need not be coloured
        order = sorted(range(len(scene.bodies)), key=self._casters.size)
        shown = [(i, geom) for i in order for geom in scene.bodies[i].geoms if geom.visible]
        self._pieces = [Piece(i, geom.pose, *_add(geom, self._client)) for i, geom in shown]
        self._owner = np.full(pybullet.getNumBodies(self._client) + 1, -1, np.int16)
        for piece in self._pieces:
            self._owner[list(piece.numbers)] = piece.body

    def draw(self, shot: Shot, *, depth: bool = False) -> Frame:
        """Draw the bodies where the shot places them."""
        check(self._scene, shot)
        camera, light = find(self._scene, shot.camera), self._scene.light
        self._place(shot.poses, camera)
        lit = self._smooth(camera)
        image = self._draw(camera, self._size, light.ambient, 0.0)
        ids, distance = self._owner[image[4]], _metres(image[3], camera)
        distance[ids < 0] = 0
        direct = np.maximum(lit - image[2][..., :3] - np.float32(0.5), 0)
        shaded = np.float32(SHADE) * self._occlusion(camera, shot, distance)
        return Frame(quantize(lit - shaded[..., None] * direct), ids, distance if depth else None)

    def close(self) -> None:
        """Free the client; the renderer can't be used any more."""
        pybullet.disconnect(self._client)

    def _place(self, poses: Sequence[Pose], camera: Camera) -> None:
        """Put the sides that face the camera where they belong, and all others out of sight."""
        for piece in self._pieces:
            pose = compose(poses[piece.body], piece.pose)
            eye = np.append(apply(inverse(pose), camera.pose.position), 1.0)
            for number, faces in zip(piece.numbers, piece.planes @ eye > 0, strict=True):
                x, y, z = (pose if faces else NOWHERE).position.tolist()
                w, *turn = pose.orientation.tolist()
                pybullet.resetBasePositionAndOrientation(number, [x, y, z], [*turn, w], self._client)

    def _smooth(self, camera: Camera) -> Image:
        """Colours 0..255 (h, w, 3) without shadows, the mean of four for every pixel, on the scene's background."""
        width, height = self._size
        image = self._draw(camera, (2 * width, 2 * height), self._scene.light.ambient, self._scene.light.diffuse)
        empty, sky = halve(image[4] < 0), np.rint(255 * np.asarray(self._scene.background)).astype(np.float32)
        # TinyRenderer cuts the fraction of a byte off: half a byte is missing on average.
        mean: Image = halve(image[2])[..., :3] + np.float32(0.5)
        mean += empty[..., None] * (sky - np.float32(WHITE + 0.5))
        return mean

    def _occlusion(self, camera: Camera, shot: Shot, depth: NDArray[np.float32]) -> Image:
        """How much of each point of a picture, at `depth` (h, w), lies in shadow: 0..1."""
        region = self._casters.region(camera, shot)
        sun, side = Sun(region, self._scene.light.direction), round(TEXELS * max(self._size))
        casters = [pose if casts else NOWHERE for pose, casts in zip(shot.poses, region.casts, strict=True)]
        self._place(casters, sun.camera)
        image = self._draw(sun.camera, (side, side), 1.0, 0.0)
        seen = _metres(image[3], sun.camera)
        seen[image[4] < 0] = np.inf
        return sun.occlusion(camera, depth, seen)

    def _draw(self, camera: Camera, size: tuple[int, int], ambient: float, diffuse: float) -> Any:
        """What PyBullet gives: at 2 colours (h, w, 4), at 3 depths 0..1, at 4 the numbers of its bodies (h, w)."""
        width, height = size
        projection = projection_matrix(camera, width / height)
        # TinyRenderer samples the corners of the pixels, not their centres.
        projection[0, 2] += 1 / width
        projection[1, 2] += 1 / height
        return pybullet.getCameraImage(
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


def _metres(z: NDArray[np.float32], camera: Camera) -> NDArray[np.float32]:
    """Undo OpenGL's projection of depths 0..1."""
    near, far = camera.near, camera.far
    return (far * near / (far - (far - near) * z.astype(np.float64))).astype(np.float32)


def _add(geom: Geom, client: int) -> tuple[tuple[int, ...], Array]:
    """Add the sides of a geometry; return their numbers in PyBullet and their planes."""
    image = geom.surface.texture
    if image:
        texture(image)  # says what is wrong with the file, if anything
    number = pybullet.loadTexture(image, physicsClientId=client) if image else None
    facets, planes = zip(*sides(tessellate(geom.shape)), strict=True)
    bodies = tuple(_side(geom, one, client) for one in facets)
    for body in bodies if image else ():
        pybullet.changeVisualShape(body, -1, textureUniqueId=number, physicsClientId=client)
    return bodies, np.stack(planes)


def _side(geom: Geom, facets: Facets, client: int) -> int:
    color = (1.0, 1.0, 1.0) if geom.surface.texture else whole(geom.surface.color)
    with lists(facets) as mesh:
        shape = pybullet.createVisualShape(
            pybullet.GEOM_MESH, rgbaColor=[*color, 1.0], specularColor=[0, 0, 0], physicsClientId=client, **mesh
        )
    if shape < 0:
        raise WmsError(f"PyBullet can't draw '{geom.name}'; expected a mesh of fewer than 131072 vertices")
    return int(pybullet.createMultiBody(baseVisualShapeIndex=shape, physicsClientId=client))
