"""Meshes that are scaled along each axis, or mirrored: in a spec, in a URDF, in an MJCF."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from tests.assets.specs import HERE, named, scene, spec
from wmspec.sim.scene.model import Body
from wmspec.sim.scene.model.bounds import world_box
from wmspec.sim.scene.model.transform import apply
from wmspec.sim.shapes import Mesh

SCALES = [(1.0, 1.0, 1.0), (0.1, 0.2, 0.3), (1.0, -1.0, 1.0), (-0.5, 2.0, -1.0), (-1.0, -1.0, -1.0)]
URDF = """<robot name="r"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>
<collision><origin xyz="0 0 0.2" rpy="0.3 0 0.5"/><geometry><mesh filename="w.obj" scale="{0} {1} {2}"/></geometry>
</collision></link></robot>"""
MJCF = """<mujoco><asset><mesh name="w" file="w.obj" scale="{0} {1} {2}"/></asset><worldbody><body name="a">
<inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/><freejoint/>
<geom type="mesh" mesh="w" pos="0 0 0.2" axisangle="1 2 3 40"/></body></worldbody></mujoco>"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "w.obj").write_bytes((HERE / "parts/wedge.obj").read_bytes())
    return tmp_path


def corners(body: Body) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """The points of the mesh of a body in the world, in a fixed order, after a look at which side is out."""
    (geom,) = (g for g in body.geoms if g.visible)
    assert isinstance(geom.shape, Mesh)
    solid = trimesh.Trimesh(geom.shape.points, geom.shape.faces)
    assert solid.is_watertight
    assert solid.volume > 0
    points = apply(body.pose, apply(geom.pose, geom.shape.points))
    return np.asarray(points[np.lexsort(np.round(points, 6).T)])


@pytest.mark.parametrize("scale", SCALES)
def test_a_scaled_mesh_is_the_mesh_that_was_scaled(folder: Path, scale: tuple[float, float, float]) -> None:
    """The same points, outside out, the same mass by density, at rest at the same height."""
    mesh = trimesh.load(folder / "w.obj", force="mesh", process=False)
    mesh.vertices = mesh.vertices * scale
    if np.prod(scale) < 0:
        mesh.invert()
    mesh.export(folder / "scaled.obj", digits=12)
    ground = "object ground { shape: plane  size: 9 m  at: (0, 0, 0)  fixed: true }"
    one, other = (
        named(scene(spec(f"{ground}\nobject a {{ file: {said}  on: ground at (0, 0)  yaw: 20 deg }}", folder)), "a")
        for said in (f'"w.obj"  scale: {scale}', '"scaled.obj"')
    )
    np.testing.assert_allclose(corners(one), corners(other), atol=1e-6)
    assert one.inertia is not None
    assert other.inertia is not None
    assert one.inertia.mass == pytest.approx(other.inertia.mass, rel=1e-6)
    assert world_box(one.geoms, one.pose)[0][2] == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("scale", SCALES)
def test_meshes_of_a_urdf_are_scaled(folder: Path, scale: tuple[float, float, float]) -> None:
    (folder / "a.urdf").write_text(URDF.format(*scale))
    turns = "yaw: 0.5 rad  roll: 0.3 rad  at: (0, 0, 20 cm)  fixed: true"
    found = named(scene(spec('object a { file: "a.urdf"  at: (0, 0, 0) }', folder)), "a")
    expected = named(scene(spec(f'object a {{ file: "w.obj"  scale: {scale}  {turns} }}', folder)), "a")
    np.testing.assert_allclose(corners(found), corners(expected), atol=1e-6)


@pytest.mark.parametrize("scale", SCALES)
def test_meshes_of_an_mjcf_are_placed_as_in_mujoco(folder: Path, scale: tuple[float, float, float]) -> None:
    mujoco = pytest.importorskip("mujoco")
    (folder / "a.xml").write_text(MJCF.format(*scale))
    found = corners(named(scene(spec('object a { file: "a.xml"  at: (0, 0, 0) }', folder)), "a"))
    model = mujoco.MjModel.from_xml_path(str(folder / "a.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    theirs = model.mesh_vert @ data.geom_xmat[0].reshape(3, 3).T + data.geom_xpos[0]
    np.testing.assert_allclose(found, theirs[np.lexsort(np.round(theirs, 6).T)], atol=1e-6)
