"""The parity look in PyBullet's TinyRenderer (on the CPU, no OpenGL)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmspec.backends.pybullet.lists import lists
from wmspec.backends.pybullet.shadow import Sun
from wmspec.errors import WmsError
from wmspec.scene.camera import find, projection_matrix, view_matrix
from wmspec.scene.color import texture, whole
from wmspec.scene.model import Camera, Frame, Geom, Pose, Scene, Shot
from wmspec.scene.picture import Image, check, fill, halve, quantize
from wmspec.scene.shadow import SHADE, Casters
from wmspec.scene.silence import silence
from wmspec.scene.tessellate import tessellate
from wmspec.scene.transform import compose

with silence():
    import pybullet

NOWHERE = Pose(np.array([0.0, 0.0, 1e6]), np.array([1.0, 0.0, 0.0, 0.0]))
"""Where ground waits while shadows are drawn: it casts none, but would take most of the time."""


def renderer(scene: Scene, width: int, height: int) -> Renderer:
    """Make a renderer of `width` x `height` pixels."""
    return Renderer(scene, width, height)


class Renderer:
    """Draws one scene: every visible geometry is a massless body of a client of its own."""

    def __init__(self, scene: Scene, width: int, height: int) -> None:
        self._scene, self._casters, self._size = scene, Casters(scene), (width, height)
        self._client = pybullet.connect(pybullet.DIRECT)
        self._parts = [(i, geom) for i, body in enumerate(scene.bodies) for geom in body.geoms if geom.visible]
        self._drawn = [_add(geom, self._client) for _, geom in self._parts]
        self._owner = np.full(max(self._drawn, default=0) + 2, -1, np.int16)
        self._owner[self._drawn] = [i for i, _ in self._parts]

    def draw(self, shot: Shot, *, depth: bool = False) -> Frame:
        """Draw the bodies where the shot places them."""
        check(self._scene, shot)
        self._place(shot.poses)
        camera, light = find(self._scene, shot.camera), self._scene.light
        fine, fine_ids, fine_depth = self._image(camera, 2, light.ambient, light.diffuse)
        dark, ids, distance = self._image(camera, 1, light.ambient, 0.0)
        shaded = halve(self._occlusion(camera, shot, fine_depth))
        lit = halve(fill(fine, fine_ids, self._scene.background))
        direct = np.where((ids >= 0)[..., None], np.maximum(lit - dark, 0), np.float32(0))
        rgb = quantize(lit - np.float32(SHADE) * shaded[..., None] * direct)
        return Frame(rgb, ids, distance if depth else None)

    def close(self) -> None:
        """Free the client; the renderer can't be used any more."""
        pybullet.disconnect(self._client)

    def _place(self, poses: Sequence[Pose]) -> None:
        for drawn, (i, geom) in zip(self._drawn, self._parts, strict=True):
            pose = compose(poses[i], geom.pose)
            w, x, y, z = pose.orientation.tolist()
            pybullet.resetBasePositionAndOrientation(drawn, pose.position.tolist(), [x, y, z, w], self._client)

    def _image(
        self, camera: Camera, scale: int, ambient: float, diffuse: float
    ) -> tuple[Image, NDArray[np.int16], NDArray[np.float32]]:
        """Colours 0..255, ids and depth of a picture `scale` times as large as asked for."""
        width, height = (scale * side for side in self._size)
        image = self._draw(camera, width, height, ambient, diffuse)
        rgb = np.asarray(image[2], np.uint8).reshape(height, width, 4)[..., :3]
        marks = np.asarray(image[4], np.int32).reshape(height, width)
        z = np.asarray(image[3], np.float32).reshape(height, width)
        ids = self._owner[marks]
        # TinyRenderer cuts the fraction of a byte off: half a byte is missing on average.
        return rgb + np.float32(0.5), ids, np.where(ids >= 0, _metres(z, camera), np.float32(0))

    def _occlusion(self, camera: Camera, shot: Shot, depth: NDArray[np.float32]) -> Image:
        """Which points of a picture lie in shadow: 1.0 or 0.0, of the shape of `depth`."""
        region = self._casters.region(camera, shot)
        self._place([pose if casts else NOWHERE for pose, casts in zip(shot.poses, region.casts, strict=True)])
        sun, side = Sun(region, self._scene.light.direction), 2 * max(self._size)
        image = self._draw(sun.camera, side, side, 1.0, 0.0)
        seen = _metres(np.asarray(image[3], np.float32), sun.camera)
        seen[np.asarray(image[4], np.int32) < 0] = np.inf
        return sun.occlusion(camera, depth, seen.reshape(side, side))

    def _draw(self, camera: Camera, width: int, height: int, ambient: float, diffuse: float) -> Any:
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


def _add(geom: Geom, client: int) -> int:
    """Add a geometry; return its number in PyBullet."""
    facets, image = tessellate(geom.shape), geom.surface.texture
    color = (1.0, 1.0, 1.0) if image else whole(geom.surface.color)
    with lists(facets) as mesh:
        shape = pybullet.createVisualShape(
            pybullet.GEOM_MESH, rgbaColor=[*color, 1.0], specularColor=[0, 0, 0], physicsClientId=client, **mesh
        )
    if shape < 0:
        raise WmsError(f"PyBullet can't draw '{geom.name}'; expected a mesh of fewer than 131072 vertices")
    body: int = pybullet.createMultiBody(baseVisualShapeIndex=shape, physicsClientId=client)
    if image:
        texture(image)  # says what is wrong with the file, if anything
        number = pybullet.loadTexture(image, physicsClientId=client)
        pybullet.changeVisualShape(body, -1, textureUniqueId=number, physicsClientId=client)
    return body
