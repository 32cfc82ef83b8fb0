"""The parity look in MuJoCo's classic renderer (OpenGL; without a display through EGL)."""

from __future__ import annotations

import math
import os
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmspec.core.crash import in_our_code
from wmspec.core.diagnostics import GraphicsError
from wmspec.core.memoize import LRU
from wmspec.core.native_output import silence
from wmspec.sim.scene.model import Camera, Frame, Geom, Scene, Shot
from wmspec.sim.scene.render.boxes import Edges
from wmspec.sim.scene.render.camera import find, seeing
from wmspec.sim.scene.render.color import texture, whole
from wmspec.sim.scene.render.contact_shadow import ContactShadows
from wmspec.sim.scene.render.picture import check
from wmspec.sim.scene.render.shadow import SHADE, Region
from wmspec.sim.scene.render.texcoords import texcoords
from wmspec.sim.scene.render.window import Moving, Window, full
from wmspec.sim.shapes import Shape

from .backdrop import REMEMBERED, Backdrop, Layer, key
from .body_subset import Cast

with silence():
    import mujoco

SHADOW_MAP = 1024
BIAS = 0.35
"""How many texels of the shadow map a shadow begins behind its caster, see `Renderer._aim`.

MuJoCo adds one and a half times what a surface falls away beside a texel. Depths are rounded by nearly as much as this:
with a whole texel flat tops have speckles.
"""
SAMPLES = 4
UNSEEN = 5
"""The group of geometries that MuJoCo is told not to draw."""

WIDEST = 0.8
"""Of a picture in which what moves takes more than this share, all is drawn at once."""

GL_RGBA = 0x1908

_BACKDROPS: LRU[bytes, Backdrop] = LRU(REMEMBERED)


class Renderer:
    """Draws one scene: every body is a mocap body, so a shot is a matter of setting poses.

    Raises WmsError where OpenGL is missing.
    """

    def __init__(self, scene: Scene, width: int, height: int) -> None:
        self._scene, self._size, self._contact = scene, (width, height), ContactShadows(scene)
        still = [i for i, body in enumerate(scene.bodies) if body.motion == "static"]
        self._every, self._still = (Cast(scene, some, width / height) for some in (range(len(scene.bodies)), still))
        self._moving = Moving(scene)
        self._model: Any = build(scene, width, height).compile()
        self._data: Any = mujoco.MjData(self._model)
        self._owner = np.append(self._model.body_mocapid[self._model.geom_bodyid], -1)
        self._view: Any = mujoco.MjvScene(self._model, maxgeom=self._model.ngeom + 100)
        self._gl, self._context = _graphics(self._model, width, height)
        self._open = False
        """Whether the background was seen in a picture; it takes some 4 % of the time, and is left out until then."""

    def draw(self, shot: Shot, *, depth: bool = False) -> Frame:
        """Draw the bodies where the shot places them."""
        check(self._scene, shot)
        self._gl.make_current()
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        for i, pose in enumerate(shot.poses):
            self._data.mocap_pos[i], self._data.mocap_quat[i] = pose.position, pose.orientation
        eye = seeing(self._scene, shot)
        region = self._every.region(eye, shot)
        layer = self._on_backdrop(eye, region, shot) or self._layer(self._every, eye, region, shot, full(*self._size))
        rgb = self._contact.cast(layer.rgb, layer.ids, layer.depth, eye, shot)
        return Frame(rgb, layer.ids, layer.depth if depth else None)

    def repaint(self, scene: Scene) -> bool:
        """Draw a scene from now on that differs in colours only."""
        self._scene = scene
        for i, body in enumerate(scene.bodies):
            for j, geom in enumerate(body.geoms):
                if geom.visible:
                    self._model.mat(f"b{i}g{j}").rgba[:3] = geom.surface.color
        return True

    def close(self) -> None:
        """Free what the graphics context holds of the scene; the renderer can't be used any more."""
        self._gl.make_current()
        self._context.free()

    def _on_backdrop(self, eye: Camera, region: Region, shot: Shot) -> Layer | None:
        """What moves, drawn with all around it on a picture of what stands still; None where that would gain nothing.

        That is where nothing stands still or the camera rides. Where what moves widens the sun's map, shadows would
        have a seam.
        """
        rides = find(self._scene, shot.camera).body is not None
        if rides or not self._still.bodies or not region.same(self._still.region(eye, shot)):
            return None
        known = key(self._scene, self._still.bodies, eye, shot, self._size)
        backdrop = _BACKDROPS.get(known, lambda: self._backdrop(eye, region, shot))
        window = self._moving.window(backdrop.lit, eye, shot, self._size, _texel(region))
        if window.share > WIDEST:
            return None
        layer = backdrop.layer.numbered(self._still.bodies)
        return layer.over(window, self._layer(self._every, eye, region, shot, window)) if window.share else layer

    def _backdrop(self, eye: Camera, region: Region, shot: Shot) -> Backdrop:
        layer = self._layer(self._still, eye, region, shot, full(*self._size))
        return Backdrop(layer.counted(self._still.bodies), self._moving.lit(layer.ids, layer.depth, eye))

    def _layer(self, cast: Cast, eye: Camera, region: Region, shot: Shot, window: Window) -> Layer:
        """Some bodies in a window of the picture, without contact shadows."""
        self._aim(cast, eye, region, shot, window)
        rgb = self._colors(window)
        ids = self._bodies(window)
        return Layer(rgb, ids, np.where(ids >= 0, self._distance(window), np.float32(0)))

    def _aim(self, cast: Cast, eye: Camera, region: Region, shot: Shot, window: Window) -> None:
        """Turn camera and shadow map to what's to be seen, and leave out what is not, nor throws a shadow there.

        MuJoCo offsets shadows by four steps of a 24-bit depth map that reaches from the near plane to the far plane
        (`render_gl3.c`), which is too little for a small map: surfaces would shade themselves. So the far plane is
        put where four steps are `BIAS` texels; the camera's own depth has floating point, and loses nothing by it.
        """
        camera = cast.nearest(eye, shot)
        far = max(camera.far, BIAS * _texel(region) * 2**24 / 4)
        self._model.vis.map.znear, self._model.vis.map.zfar = camera.near, far
        self._context.shadowClip = region.half
        self._model.light_pos[:] = region.center - self._scene.light.direction * region.reach
        edges = window.edges(camera)
        sight = cast.sight(camera, edges, shot, _texel(region))
        self._model.geom_group[:] = np.where(sight.seen, 0, UNSEEN)
        number = [one.name for one in self._scene.cameras].index(camera.name)
        self._model.cam_pos[number], self._model.cam_quat[number] = camera.pose.position, camera.pose.orientation
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_camlight(self._model, self._data)
        free = mujoco.MjvCamera()
        free.type = mujoco.mjtCamera.mjCAMERA_FIXED
        free.fixedcamid = number
        every = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(self._model, self._data, mujoco.MjvOption(), None, free, every, self._view)
        self._frame(camera, edges)
        for i in np.flatnonzero(~sight.casts[sight.seen]):
            self._view.geoms[i].category = mujoco.mjtCatBit.mjCAT_DECOR  # which casts no shadow

    def _frame(self, camera: Camera, edges: Edges) -> None:
        """Let the picture show what lies within the edges."""
        left, right, down, up = (camera.near * edge for edge in edges)
        for eye in self._view.camera:
            eye.frustum_center, eye.frustum_width = (left + right) / 2, (right - left) / 2
            eye.frustum_bottom, eye.frustum_top = down, up

    def _colors(self, window: Window) -> NDArray[np.uint8]:
        """Bytes (h, w, 3), the first row on top."""
        rgba = self._render(window, ids=False)
        if not self._open and (rgba[..., 3] < 255).any():  # a sample, of the four of a pixel, that nothing covers
            self._open = True
            rgba = self._render(window, ids=False)
        return np.ascontiguousarray(rgba[..., :3])

    def _render(self, window: Window, ids: bool) -> NDArray[np.uint8]:
        """Bytes (h, w, 4), the first row on top: colours and what is covered, or what numbers the geometries."""
        self._view.flags[mujoco.mjtRndFlag.mjRND_SKYBOX] = self._open
        self._view.flags[mujoco.mjtRndFlag.mjRND_SEGMENT] = ids
        self._view.flags[mujoco.mjtRndFlag.mjRND_IDCOLOR] = ids
        rgba, part = np.empty((window.height, window.width, 4), np.uint8), _rect(window)
        mujoco.mjr_render(part, self._view, self._context)
        mujoco.mjr_readPixels(rgba, None, part, self._context)
        return rgba[::-1]

    def _distance(self, window: Window) -> NDArray[np.float32]:
        """Metres (h, w) along the view axis in what was rendered last.

        This undoes OpenGL's projection: the reversed depth is 1 at the near plane and 0 at the far plane.
        """
        z = np.empty((window.height, window.width), np.float32)
        mujoco.mjr_readPixels(None, z, _rect(window), self._context)
        near, far = float(self._model.vis.map.znear), float(self._model.vis.map.zfar)
        away = z[::-1].astype(np.float64)
        away *= far - near
        away += near
        return np.asarray(far * near / away, np.float32)

    def _bodies(self, window: Window) -> NDArray[np.int16]:
        """The scene's body in every pixel (h, w), by its colour: 0 is the background, n + 1 the n-th drawn geometry."""
        number = self._render(window, ids=True).view("<u4")[..., 0] & 0xFFFFFF
        if int(number.max()) > self._view.ngeom:
            raise GraphicsError(
                "MuJoCo can't tell things apart with this OpenGL, which mixes the numbers that it draws; draw in "
                "software: set __EGL_VENDOR_LIBRARY_FILENAMES to Mesa's file, see 'wmspec doctor'"
            )
        table = np.full(self._view.ngeom + 1, -1, np.int16)
        for geom in self._view.geoms[: self._view.ngeom]:
            if geom.segid >= 0 and geom.objtype == mujoco.mjtObj.mjOBJ_GEOM:
                table[geom.segid + 1] = self._owner[geom.objid]
        bodies: NDArray[np.int16] = table.take(number)
        return bodies


def _rect(window: Window) -> Any:
    """Where a window is drawn: in the corner of the buffer."""
    return mujoco.MjrRect(0, 0, window.width, window.height)


def _texel(region: Region) -> float:
    """The width (m) of a texel of the sun's map."""
    return 2 * region.half / SHADOW_MAP


def _graphics(model: Any, width: int, height: int) -> tuple[Any, Any]:
    """An OpenGL context and the model's data in it."""
    try:
        gl = _opengl(width, height)
        gl.make_current()
        with silence():
            context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
    except Exception as error:  # every back end has its own
        if in_our_code(error):
            raise
        raise GraphicsError(
            f"MuJoCo can't draw: no OpenGL ({error}); set MUJOCO_GL=egl and install Mesa's EGL "
            "(Debian: libegl1 libgl1-mesa-dri), see 'wmspec doctor'"
        ) from error
    context.readDepthMap, context.readPixelFormat = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR, GL_RGBA
    return gl, context


@cache
def _opengl(width: int, height: int) -> Any:
    """An OpenGL context, kept for all renderers: by EGL, unless MUJOCO_GL is set or there is a display."""
    with silence():
        if "MUJOCO_GL" in os.environ or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
            from mujoco.gl_context import GLContext
        else:
            from mujoco.egl import GLContext
        return GLContext(width, height)


def build(scene: Scene, width: int, height: int) -> Any:
    """The model: body i of the scene is the mocap body `b{i}`, its geometry j has the material `b{i}g{j}`."""
    spec = mujoco.MjSpec()
    _settings(spec, scene, width, height)
    _lights(spec, scene)
    assets = _Assets(spec)
    for i, body in enumerate(scene.bodies):
        node = spec.worldbody.add_body(name=f"b{i}", mocap=True, pos=body.pose.position, quat=body.pose.orientation)
        for j, geom in enumerate(body.geoms):
            if geom.visible:
                _geom(assets, node, geom, f"b{i}g{j}")
    for i, camera in enumerate(scene.cameras):
        pose = camera.pose
        spec.worldbody.add_camera(
            name=f"c{i}", pos=pose.position, quat=pose.orientation, fovy=math.degrees(camera.fovy)
        )
    return spec


def _settings(spec: Any, scene: Scene, width: int, height: int) -> None:
    spec.stat.extent, spec.stat.center = 1.0, np.zeros(3)  # so that lengths below `visual` are in metres
    spec.visual.global_.offwidth, spec.visual.global_.offheight = width, height
    spec.visual.quality.offsamples, spec.visual.quality.shadowsize = SAMPLES, SHADOW_MAP
    spec.visual.headlight.active = 0
    sky = whole(scene.background)
    flat, skybox = mujoco.mjtBuiltin.mjBUILTIN_FLAT, mujoco.mjtTexture.mjTEXTURE_SKYBOX
    spec.add_texture(name="sky", type=skybox, builtin=flat, rgb1=sky, rgb2=sky, width=16, height=16)


def _lights(spec: Any, scene: Scene) -> None:
    """The sun, once with shadows and once without, which also carries the ambient light."""
    light = scene.light
    for name, share, shadow in (("sun", SHADE, True), ("sky", 1 - SHADE, False)):
        spec.worldbody.add_light(
            name=name,
            type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
            dir=light.direction,
            castshadow=shadow and light.shadows,
            diffuse=np.full(3, light.diffuse * share),
            ambient=np.full(3, 0.0 if shadow else light.ambient),
            specular=np.zeros(3),
        )


class _Assets:
    """The meshes and images of a model: one for all shapes that have it."""

    def __init__(self, spec: Any) -> None:
        self.spec = spec
        self._meshes: dict[tuple[Shape, tuple[float, float] | None], str] = {}
        self._images: set[str] = set()

    def mesh(self, geom: Geom) -> str:
        """The name of the mesh of a geometry, with the texture coordinates at which it wears its image."""
        key = geom.shape, geom.surface.repeats if geom.surface.texture else None
        if key not in self._meshes:
            self._meshes[key] = name = f"m{len(self._meshes)}"
            facets = texcoords(geom)
            self.spec.add_mesh(
                name=name,
                uservert=facets.points.ravel(),
                usernormal=facets.normals.ravel(),
                usertexcoord=(facets.st * [1, -1] + [0, 1]).ravel(),
                userface=facets.faces.ravel(),
                userfacenormal=facets.faces.ravel(),
                userfacetexcoord=facets.faces.ravel(),
                inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
            )
        return self._meshes[key]

    def image(self, path: str) -> str:
        """The name of the texture of an image file."""
        if path not in self._images:
            self._images.add(path)
            image, kind = texture(path), mujoco.mjtTexture.mjTEXTURE_2D
            made = self.spec.add_texture(name=path, type=kind, height=image.shape[0], width=image.shape[1], nchannel=3)
            made.data = image.tobytes()
        return path


def _geom(assets: _Assets, node: Any, geom: Geom, name: str) -> None:
    material = assets.spec.add_material(name=name, specular=0.0, shininess=0.0, reflectance=0.0)
    material.rgba = [*geom.surface.color, 1.0]
    if geom.surface.texture is not None:
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = assets.image(geom.surface.texture)
    node.add_geom(
        type=mujoco.mjtGeom.mjGEOM_MESH,
        meshname=assets.mesh(geom),
        material=name,
        pos=geom.pose.position,
        quat=geom.pose.orientation,
        contype=0,
        conaffinity=0,
    )
