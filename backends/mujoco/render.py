"""The parity look in MuJoCo's classic renderer (OpenGL, through EGL without a display)."""

from __future__ import annotations

import math
import os
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wmspec.core.crash import is_own_error
from wmspec.core.diagnostics import GraphicsError
from wmspec.core.memoize import LRU
from wmspec.core.native_output import silence
from wmspec.sim.scene.model import Camera, Frame, Geom, Scene, Shot
from wmspec.sim.scene.render.boxes import ViewEdges
from wmspec.sim.scene.render.camera import find_camera, world_camera
from wmspec.sim.scene.render.color import load_texture, round_up_color
from wmspec.sim.scene.render.contact_shadow import ContactShadows
from wmspec.sim.scene.render.picture import require_all_poses
from wmspec.sim.scene.render.shadow import ShadowMapRegion
from wmspec.sim.scene.render.texcoords import texcoords
from wmspec.sim.scene.render.window import MovingBodies, Window, full_window
from wmspec.sim.shapes import Shape

from .backdrop import MAX_BACKDROPS, Backdrop, BodySubset, ImageLayer, key
from .sun import SunMap

with silence():
    import mujoco

SHADOW_MAP = 1024
SHADOW_BIAS = 0.35
"""Texels of the shadow map by which a shadow starts behind its caster (see `Renderer._aim`).

MuJoCo adds 1.5 times the slope of a surface per texel. Depths are rounded by nearly this amount; with a full texel,
flat tops have speckles.
"""
SAMPLES = 4
HIDDEN_GROUP = 5
"""Geom group that MuJoCo does not draw."""

MAX_WINDOW_SHARE = 0.8
"""If moving bodies cover a larger share of the picture, everything is drawn at once."""

GL_RGBA = 0x1908

_BACKDROPS: LRU[bytes, Backdrop] = LRU(MAX_BACKDROPS)


class Renderer:
    """Draws one scene: every body is a mocap body, so a shot sets poses only.

    Raises WmsError if OpenGL is missing.
    """

    def __init__(self, scene: Scene, width: int, height: int) -> None:
        self._scene, self._size, self._contact = scene, (width, height), ContactShadows(scene)
        still = [i for i, body in enumerate(scene.bodies) if body.motion == "static"]
        self._every, self._still = (
            BodySubset(scene, some, width / height) for some in (range(len(scene.bodies)), still)
        )
        self._moving = MovingBodies(scene)
        self._model: Any = build(scene, width, height).compile()
        self._data: Any = mujoco.MjData(self._model)
        self._owner = np.append(self._model.body_mocapid[self._model.geom_bodyid], -1)
        self._view: Any = mujoco.MjvScene(self._model, maxgeom=self._model.ngeom + 100)
        self._view.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = False
        self._gl, self._context = _graphics(self._model, width, height)
        self._open = False
        """Whether the background has been visible; until then it is not drawn, which saves about 4 %."""

    def draw(self, shot: Shot, *, depth: bool = False) -> Frame:
        """Draw the bodies at the poses of the shot."""
        require_all_poses(self._scene, shot)
        self._gl.make_current()
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        for i, pose in enumerate(shot.poses):
            self._data.mocap_pos[i], self._data.mocap_quat[i] = pose.position, pose.orientation
        eye = world_camera(self._scene, shot)
        region = self._every.region(eye, shot)
        layer = self._on_backdrop(eye, region, shot) or self._layer(
            self._every, eye, region, shot, full_window(*self._size)
        )
        rgb = self._contact.cast(layer.rgb, layer.ids, layer.depth, eye, shot)
        return Frame(rgb, layer.ids, layer.depth if depth else None)

    def repaint(self, scene: Scene) -> bool:
        """Switch to a scene that differs in colours only."""
        self._scene = scene
        for i, body in enumerate(scene.bodies):
            for j, geom in enumerate(body.geoms):
                if geom.visible:
                    self._model.mat(f"b{i}g{j}").rgba[:3] = geom.surface.color
        return True

    def close(self) -> None:
        """Free the data of the scene in the graphics context."""
        self._gl.make_current()
        self._context.free()

    def _on_backdrop(self, eye: Camera, region: ShadowMapRegion, shot: Shot) -> ImageLayer | None:
        """Draw moving bodies over a picture of static bodies; None where that saves nothing.

        That is the case without static bodies or with an attached camera. If moving bodies enlarge the shadow map,
        shadows would have a seam.
        """
        rides = find_camera(self._scene, shot.camera).body is not None
        if rides or not self._still.bodies or not region.same(self._still.region(eye, shot)):
            return None
        known = key(self._scene, self._still.bodies, eye, shot, self._size)
        backdrop = _BACKDROPS.get(known, lambda: self._backdrop(eye, region, shot))
        window = self._moving.window(backdrop.lit, eye, shot, self._size, _texel(region))
        if window.share > MAX_WINDOW_SHARE:
            return None
        layer = backdrop.layer.numbered(self._still.bodies)
        return layer.over(window, self._layer(self._every, eye, region, shot, window)) if window.share else layer

    def _backdrop(self, eye: Camera, region: ShadowMapRegion, shot: Shot) -> Backdrop:
        layer = self._layer(self._still, eye, region, shot, full_window(*self._size))
        return Backdrop(layer.counted(self._still.bodies), self._moving.lit(layer.ids, layer.depth, eye))

    def _layer(self, cast: BodySubset, eye: Camera, region: ShadowMapRegion, shot: Shot, window: Window) -> ImageLayer:
        """Draw a subset of bodies in a window, without contact shadows."""
        self._aim(cast, eye, region, shot, window)
        rgb = self._colors(window)
        ids = self._bodies(window)
        depth = np.where(ids >= 0, self._distance(window), np.float32(0))
        if self._scene.light.shadows:
            rgb = self._sun_map(region).shade(rgb, ids, depth, eye, self._scene.light, window)
        return ImageLayer(rgb, ids, depth)

    def _aim(self, cast: BodySubset, eye: Camera, region: ShadowMapRegion, shot: Shot, window: Window) -> None:
        """Aim camera and shadow map, and hide shapes that neither appear nor cast a visible shadow.

        MuJoCo offsets shadows by four steps of a 24-bit depth map between near and far plane (`render_gl3.c`), too
        little for a small map: surfaces would shade themselves. So the far plane is placed where four steps are
        `SHADOW_BIAS` texels. The camera's depth is floating point and unaffected.
        """
        camera = cast.nearest(eye, shot)
        far = max(camera.far, SHADOW_BIAS * _texel(region) * 2**24 / 4)
        self._model.vis.map.znear, self._model.vis.map.zfar = camera.near, far
        self._context.shadowClip = region.half
        self._model.light_pos[:] = region.center - self._scene.light.direction * region.reach
        edges = window.edges(camera)
        sight = cast.sight(camera, edges, shot, _texel(region))
        self._model.geom_group[:] = np.where(sight.seen, 0, HIDDEN_GROUP)
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
            self._view.geoms[i].category = mujoco.mjtCatBit.mjCAT_DECOR  # decor casts no shadow

    def _frame(self, camera: Camera, edges: ViewEdges) -> None:
        """Restrict the view to these edges."""
        left, right, down, up = (camera.near * edge for edge in edges)
        for eye in self._view.camera:
            eye.frustum_center, eye.frustum_width = (left + right) / 2, (right - left) / 2
            eye.frustum_bottom, eye.frustum_top = down, up

    def _colors(self, window: Window) -> NDArray[np.uint8]:
        """Return bytes (h, w, 3), top row first."""
        rgba = self._render(window, ids=False)
        if not self._open and (rgba[..., 3] < 255).any():  # one of four samples shows the background
            self._open = True
            rgba = self._render(window, ids=False)
        return np.ascontiguousarray(rgba[..., :3])

    def _render(self, window: Window, ids: bool) -> NDArray[np.uint8]:
        """Return bytes (h, w, 4), top row first: colour and coverage, or encoded geom ids."""
        self._view.flags[mujoco.mjtRndFlag.mjRND_SKYBOX] = self._open
        self._view.flags[mujoco.mjtRndFlag.mjRND_SEGMENT] = ids
        self._view.flags[mujoco.mjtRndFlag.mjRND_IDCOLOR] = ids
        rgba, part = np.empty((window.height, window.width, 4), np.uint8), _rect(window)
        mujoco.mjr_render(part, self._view, self._context)
        mujoco.mjr_readPixels(rgba, None, part, self._context)
        return rgba[::-1]

    def _sun_map(self, region: ShadowMapRegion) -> SunMap:
        """Draw the shadow map for the current view; a picture of one pixel makes MuJoCo draw all of it."""
        self._view.flags[mujoco.mjtRndFlag.mjRND_SEGMENT] = False
        self._view.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = True
        mujoco.mjr_render(_rect(Window(0, 0, 1, 1, self._size)), self._view, self._context)
        self._view.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = False
        bounds = float(self._model.vis.map.znear), float(self._model.vis.map.zfar)
        return SunMap(_shadow_texels(self._context), region, *bounds)

    def _distance(self, window: Window) -> NDArray[np.float32]:
        """Return depth (h, w), m along the view axis, of the last rendering.

        This inverts OpenGL's projection: reversed depth is 1 at the near plane and 0 at the far plane.
        """
        z = np.empty((window.height, window.width), np.float32)
        mujoco.mjr_readPixels(None, z, _rect(window), self._context)
        near, far = float(self._model.vis.map.znear), float(self._model.vis.map.zfar)
        away = z[::-1].astype(np.float64)
        away *= far - near
        away += near
        return np.asarray(far * near / away, np.float32)

    def _bodies(self, window: Window) -> NDArray[np.int16]:
        """Return the body of every pixel (h, w), decoded from colours: 0 is background, n + 1 the n-th drawn geom."""
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
    """Return the viewport of a window, in the corner of the buffer."""
    return mujoco.MjrRect(0, 0, window.width, window.height)


def _shadow_texels(context: Any) -> NDArray[np.float32]:
    """Return the shadow map of a context (n, n), rows upwards."""
    from OpenGL import GL  # after EGL is chosen

    GL.glBindTexture(GL.GL_TEXTURE_2D, context.shadowTex)
    texels = GL.glGetTexImage(GL.GL_TEXTURE_2D, 0, GL.GL_DEPTH_COMPONENT, GL.GL_FLOAT)
    GL.glBindTexture(GL.GL_TEXTURE_2D, 0)
    return np.asarray(texels, np.float32).reshape(context.shadowSize, context.shadowSize)


def _texel(region: ShadowMapRegion) -> float:
    """Return the width (m) of a texel of the shadow map."""
    return 2 * region.half / SHADOW_MAP


def _graphics(model: Any, width: int, height: int) -> tuple[Any, Any]:
    """Return an OpenGL context with the data of the model."""
    try:
        gl = _opengl(width, height)
        gl.make_current()
        with silence():
            context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
    except Exception as error:  # each OpenGL backend has its own exception
        if is_own_error(error):
            raise
        raise GraphicsError(
            f"MuJoCo cannot draw: no OpenGL ({error}); set MUJOCO_GL=egl and install Mesa's EGL "
            "(Debian: libegl1 libgl1-mesa-dri), see 'wmspec doctor'"
        ) from error
    context.readDepthMap, context.readPixelFormat = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR, GL_RGBA
    return gl, context


@cache
def _opengl(width: int, height: int) -> Any:
    """Return an OpenGL context shared by all renderers: EGL, unless MUJOCO_GL is set or there is a display."""
    with silence():
        if "MUJOCO_GL" in os.environ or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
            from mujoco.gl_context import GLContext
        else:
            from mujoco.egl import GLContext
        return GLContext(width, height)


def build(scene: Scene, width: int, height: int) -> Any:
    """Return the model: body i of the scene is mocap body `b{i}`, its geom j has material `b{i}g{j}`."""
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
    spec.stat.extent, spec.stat.center = 1.0, np.zeros(3)  # lengths in `visual` are then in metres
    spec.visual.global_.offwidth, spec.visual.global_.offheight = width, height
    spec.visual.quality.offsamples, spec.visual.quality.shadowsize = SAMPLES, SHADOW_MAP
    spec.visual.headlight.active = 0
    sky = round_up_color(scene.background)
    flat, skybox = mujoco.mjtBuiltin.mjBUILTIN_FLAT, mujoco.mjtTexture.mjTEXTURE_SKYBOX
    spec.add_texture(name="sky", type=skybox, builtin=flat, rgb1=sky, rgb2=sky, width=16, height=16)


def _lights(spec: Any, scene: Scene) -> None:
    """Add the sun and ambient light."""
    light = scene.light
    spec.worldbody.add_light(
        name="sun",
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        dir=light.direction,
        castshadow=light.shadows,
        diffuse=np.full(3, light.diffuse),
        ambient=np.full(3, light.ambient),
        specular=np.zeros(3),
    )


class _Assets:
    """Meshes and images of a model, shared by equal shapes."""

    def __init__(self, spec: Any) -> None:
        self.spec = spec
        self._meshes: dict[tuple[Shape, tuple[float, float] | None], str] = {}
        self._images: set[str] = set()

    def mesh(self, geom: Geom) -> str:
        """Return the name of the mesh of a geom with its texture coordinates."""
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
        """Return the name of the texture of an image file."""
        if path not in self._images:
            self._images.add(path)
            image, kind = load_texture(path), mujoco.mjtTexture.mjTEXTURE_2D
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
