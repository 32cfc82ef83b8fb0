"""The photo renderer: path-traced colours, few paths per pixel, denoised by Open Image Denoise.

Ids and depth come from an engine's renderer.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmspec.sim.photo.library import mitsuba
from wmspec.sim.photo.light import ceiling_lights, environment_map, strengths
from wmspec.sim.photo.materials import Material, material
from wmspec.sim.scene.model import Array, Camera, Frame, Geom, Pose, Renderer, Scene, Shot, Surface
from wmspec.sim.scene.model.transform import apply, compose, rotate, rotation
from wmspec.sim.scene.render.camera import world_camera
from wmspec.sim.scene.render.color import to_bytes, to_linear, to_srgb
from wmspec.sim.scene.render.picture import require_all_poses
from wmspec.sim.scene.render.texcoords import texcoords
from wmspec.sim.shapes.facets import Facets

DEFAULT_SAMPLES = 8
"""Paths per pixel."""

BOUNCES = 5
GLASS_BOUNCES = 8
"""Additional bounces for glass: two vessels in a row."""

GUIDE_SAMPLES = 8
"""Samples of albedo that guide the denoiser; they cost a tenth of a path."""

SEED_BLOCK = 32
"""Pixels are sampled in square blocks of this side, each with its own seed. Mitsuba's default depends on the number of
cores, and so would the bytes.
"""

USD_CAMERA_AXES = np.array([-1.0, 1.0, -1.0])
"""Mitsuba's camera looks along +z with +x to the left; USD's along -z with +x to the right."""

Image = NDArray[np.float32]
"""(h, w, 4)."""


START, DESATURATION = 0.76, 0.15
"""Of the tone curve."""


@dataclass(frozen=True)
class _Piece:
    """A drawn shape: body number, pose in the body, triangles and material."""

    body: int
    pose: Pose
    facets: Facets
    material: Material


class Tracer:
    """Draws the colours of one scene in pictures of `size` (width, height) pixels with `samples` per pixel.

    Raises WmsError if Mitsuba is missing.
    """

    def __init__(self, scene: Scene, size: tuple[int, int], samples: int | None = None) -> None:
        self._mi: Any = mitsuba()
        self._size, self._samples = size, samples or DEFAULT_SAMPLES
        self._plain: Any = self._mi.load_dict({"type": "path", "max_depth": 1, "block_size": SEED_BLOCK})
        self.paint(scene)

    def paint(self, scene: Scene) -> None:
        """Switch to another scene."""
        self._scene, self._pieces = scene, _pieces(scene)
        clear = any(piece.material.clear for piece in self._pieces)
        kind, longest = (
            ("volpath", BOUNCES + GLASS_BOUNCES) if clear else ("path", BOUNCES)
        )  # volpath connects to lamps through glass
        self._paths: Any = self._mi.load_dict(
            {"type": kind, "max_depth": longest, "rr_depth": 64, "hide_emitters": True, "block_size": SEED_BLOCK}
        )
        around = self._mi.Bitmap(environment_map(scene.light, scene.background))
        upright = self._mi.ScalarTransform4f().rotate([1, 0, 0], 90)
        self._light: Any = self._mi.load_dict({"type": "envmap", "bitmap": around, "to_world": upright})

    def draw(self, shot: Shot) -> NDArray[np.uint8]:
        """Return bytes (h, w, 3) with the bodies at the poses of the shot."""
        require_all_poses(self._scene, shot)
        camera = world_camera(self._scene, shot)
        light = self._taken(self._paths, self._lit(shot, camera), camera, self._samples)
        color = self._taken(self._plain, self._glowing(shot), camera, GUIDE_SAMPLES)
        return tonemap(self._developed(light, color))

    def _lit(self, shot: Shot, camera: Camera) -> Any:
        """Return Mitsuba's scene of a shot, rebuilt from cached materials and lights."""
        shapes = self._shapes(shot, self._pieces, lambda piece: ("bsdf", piece.material.scattering))
        still = (piece for piece in self._pieces if self._scene.bodies[piece.body].motion == "static")
        bounds = (_bounds(compose(shot.poses[piece.body], piece.pose), piece.facets) for piece in still)
        for number, corners in enumerate(ceiling_lights(self._scene.light, bounds, camera.pose.position)):
            shapes[f"panel{number}"] = self._panel(*corners)
        return self._mi.load_dict({"type": "scene", "light": self._light, **shapes})

    def _glowing(self, shot: Shot) -> Any:
        """Return the scene with emissive plain colours and without glass."""
        solid = [piece for piece in self._pieces if not piece.material.clear]
        shapes = self._shapes(
            shot,
            solid,
            lambda piece: ("emitter", self._mi.load_dict({"type": "area", "radiance": piece.material.color})),
        )
        return self._mi.load_dict({"type": "scene", **shapes})

    def _shapes(
        self, shot: Shot, pieces: Iterable[_Piece], attached: Callable[[_Piece], tuple[str, Any]]
    ) -> dict[str, Any]:
        shapes = {}
        for number, piece in enumerate(pieces):
            facets, pose = piece.facets, compose(shot.poses[piece.body], piece.pose)
            properties = self._mi.Properties()
            key, value = attached(piece)
            properties[key] = value
            mesh = self._mi.Mesh("", len(facets.points), len(facets.faces), properties, True, True)
            values = self._mi.traverse(mesh)
            values["vertex_positions"] = _flat(apply(pose, facets.points))
            values["vertex_normals"] = _flat(rotate(pose.orientation, facets.normals))
            values["vertex_texcoords"] = _flat(facets.st * [1, -1] + [0, 1])
            values["faces"] = np.ascontiguousarray(facets.faces, np.uint32).ravel()
            values.update()
            shapes[f"shape{number}"] = mesh
        return shapes

    def _panel(self, low: Array, high: Array) -> Any:
        """Return a rectangle that emits sun and sky light downwards and is invisible."""
        middle, half = (low + high) / 2, (high - low) / 2
        placed = self._mi.ScalarTransform4f().translate(middle.tolist()).scale([half[0], half[1], 1])
        strength = sum(strengths(self._scene.light))
        shine = {"type": "area", "radiance": {"type": "rgb", "value": [strength] * 3}}
        glass = {"type": "null"}  # the ceiling stays visible
        return {"type": "rectangle", "to_world": placed.rotate([1, 0, 0], 180), "emitter": shine, "bsdf": glass}

    def _taken(self, integrator: Any, world: Any, camera: Camera, samples: int) -> Image:
        """Return the picture (h, w, 4) of an integrator: linear light and coverage."""
        width, height = self._size
        placed = np.eye(4)
        placed[:3, :3], placed[:3, 3] = rotation(camera.pose.orientation) * USD_CAMERA_AXES, camera.pose.position
        film = {
            "type": "hdrfilm",
            "width": width,
            "height": height,
            "pixel_format": "rgba",
            "component_format": "float32",
            "rfilter": {"type": "box"},
        }
        sensor = self._mi.load_dict(
            {
                "type": "perspective",
                "fov": math.degrees(camera.fovy),
                "fov_axis": "y",
                "near_clip": camera.near,
                "far_clip": camera.far,
                "to_world": self._mi.ScalarTransform4f(placed),
                "film": film,
                "sampler": {"type": "multijitter", "sample_count": samples},
            }
        )
        image = self._mi.render(world, sensor=sensor, integrator=integrator, seed=0)
        return np.nan_to_num(np.array(image, np.float32), posinf=0, neginf=0)

    def _developed(self, light: Image, color: Image) -> Array:
        """Return denoised linear light (h, w, 3) over the background, from light and albedo (h, w, 4)."""
        import mitsuba_oidn

        background = to_linear(self._scene.background)
        noisy, plain = (image[..., :3] + (1 - image[..., 3:]) * background for image in (light, color))
        parts = (np.ascontiguousarray(part, np.float32) for part in (noisy, np.clip(plain, 0, 1)))
        smooth: Array = np.maximum(mitsuba_oidn.denoise(*parts, hdr=True), 0).astype(np.float64)
        return smooth


class PhotoRenderer:
    """Draws one scene; `parity` is an engine's renderer of it and is closed with this one.

    Raises WmsError if Mitsuba is missing.
    """

    def __init__(self, scene: Scene, parity: Renderer, size: tuple[int, int], samples: int | None = None) -> None:
        self._tracer, self._parity = Tracer(scene, size, samples), parity

    def draw(self, shot: Shot, *, depth: bool = False) -> Frame:
        """Draw the bodies at the poses of the shot."""
        frame = self._parity.draw(shot, depth=depth)
        return Frame(self._tracer.draw(shot), frame.ids, frame.depth)

    def repaint(self, scene: Scene) -> bool:
        """Switch to a scene that differs in colours only, if the engine's renderer can."""
        if not self._parity.repaint(scene):
            return False
        self._tracer.paint(scene)
        return True

    def close(self) -> None:
        """Release all resources."""
        self._parity.close()
        del self._tracer


def tonemap(light: Array) -> NDArray[np.uint8]:
    """Return the bytes (h, w, 3) of linear light (h, w, 3), where 1 is a white surface that faces the sun.

    The highlight roll-off of Khronos' "PBR Neutral" tone mapper (2024); values below 0.76 of white keep their colour
    exactly.
    """
    peak = light.max(axis=-1, keepdims=True)
    beyond = np.maximum(peak, START) - START
    rolled = 1 - (1 - START) ** 2 / (beyond + 1 - START)
    white = 1 - 1 / (DESATURATION * (beyond + START - rolled) + 1)
    bright = light * rolled / np.maximum(peak, START)
    return to_bytes(to_srgb(np.where(peak < START, light, bright + white * (rolled - bright))))


def _pieces(scene: Scene) -> tuple[_Piece, ...]:
    materials: dict[Surface, Material] = {}

    def of(surface: Surface) -> Material:
        if surface not in materials:
            materials[surface] = material(surface)
        return materials[surface]

    shown: list[tuple[int, Geom]] = [(i, geom) for i, body in enumerate(scene.bodies) for geom in body.geoms]
    return tuple(_Piece(i, geom.pose, texcoords(geom), of(geom.surface)) for i, geom in shown if geom.visible)


def _bounds(pose: Pose, facets: Facets) -> tuple[Array, Array]:
    points = apply(pose, facets.points)
    return points.min(axis=0), points.max(axis=0)


def _flat(values: Array) -> NDArray[np.float32]:
    return np.ascontiguousarray(values, np.float32).ravel()
