"""Mesh prims of USD: the same as primitives wherever both can be said, in any unit, up axis, scale and handedness."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from tests.assets.specs import checked, named, scene, spec, tensor
from wmspec.sim.scene.model import Body
from wmspec.sim.scene.model.bounds import world_box
from wmspec.sim.scene.model.transform import apply
from wmspec.sim.shapes import Box, Mesh

#: A cube of edge 2 as quads, a pentagon of two of its sides' corners nowhere: each side out.
QUADS = """point3f[] points = [(-1,-1,-1),(1,-1,-1),(1,1,-1),(-1,1,-1),(-1,-1,1),(1,-1,1),(1,1,1),(-1,1,1),(9,9,9)]
int[] faceVertexCounts = [4,4,4,4,4,4]
int[] faceVertexIndices = [{0}]"""
SIDES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (2, 3, 7, 6), (0, 4, 7, 3), (1, 2, 6, 5))
STAGE = """#usda 1.0
(
  metersPerUnit = {meters}
  upAxis = "{up}"
)
def Xform "World" {{
  double3 xformOp:translate = (1, 2, 3)
  double xformOp:rotateY = 30
  double3 xformOp:scale = ({turn}, 1, 1)
  uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateY", "xformOp:scale"]
  def Xform "thing" ( prepend apiSchemas = ["PhysicsRigidBodyAPI"] ) {{
    double3 xformOp:rotateXYZ = (10, 20, 40)
    uniform token[] xformOpOrder = ["xformOp:rotateXYZ"]
    def {kind} "form" ( prepend apiSchemas = ["PhysicsCollisionAPI", "PhysicsMeshCollisionAPI"] ) {{
      {form}
      uniform token physics:approximation = "{way}"
      double3 xformOp:translate = (0.2, -0.3, 0.4)
      double3 xformOp:scale = {scale}
      uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]
      {more}
    }}
  }}
}}"""


def quads(left: bool = False) -> str:
    """The cube, its polygons seen from outside anticlockwise or, left-handed, clockwise."""
    corners = ", ".join(str(i) for side in SIDES for i in (side[::-1] if left else side))
    return QUADS.format(corners) + ('\nuniform token orientation = "leftHanded"' if left else "")


def written(folder: Path, name: str, kind: str = "Mesh", **said: object) -> None:
    """A stage with one body of one geometry."""
    plain = {"meters": 1, "up": "Z", "turn": 1, "scale": (1, 1, 1), "form": quads(), "way": "convexHull", "more": ""}
    (folder / name).write_text(STAGE.format(kind=kind, **(plain | said)))


def body(folder: Path, text: str) -> Body:
    """The object `a` of a spec with a floor."""
    floor = "object floor_ { shape: plane  size: 90 m  at: (0, 0, 0)  fixed: true }\n"
    return named(scene(spec(floor + text, folder)), "a")


def solid(found: Body) -> trimesh.Trimesh:
    """What is drawn of a body, in the world, after a look at which side is out."""
    (geom,) = (g for g in found.geoms if g.visible)
    assert isinstance(geom.shape, Mesh)
    made = trimesh.Trimesh(apply(found.pose, apply(geom.pose, geom.shape.points)), geom.shape.faces, process=False)
    assert made.is_watertight
    assert made.volume > 0
    return made


PLACES = [
    {"meters": meters, "up": up, "scale": scale, "turn": turn}
    for meters, up, scale, turn in product((1, 0.01), "YZ", ((1, 1, 1), (0.5, 2, 1), (-1, 1, 2)), (1, -1))
]


@pytest.mark.parametrize("said", PLACES, ids=str)
@pytest.mark.parametrize("left", [False, True])
def test_a_cube_of_polygons_is_a_cube(tmp_path: Path, said: dict[str, Any], left: bool) -> None:
    """The same volume, mass, moments, place and rest, whichever way it is mirrored."""
    written(tmp_path, "mesh.usda", form=quads(left), **said)
    written(tmp_path, "cube.usda", "Cube", form="double size = 2", **said)
    for where in ("at: (0, 0, 0)", "on: floor_ at (0, 0)  yaw: 40 deg"):
        one, other = (body(tmp_path, f'object a {{ file: "{n}.usda"  {where} }}') for n in ("mesh", "cube"))
        assert isinstance(other.geoms[0].shape, Box)
        size = float(said["meters"])
        assert solid(one).volume == pytest.approx(other.geoms[0].shape.volume, rel=1e-5)
        np.testing.assert_allclose(world_box(one.geoms, one.pose), world_box(other.geoms, other.pose), atol=1e-5 * size)
        assert one.inertia is not None
        assert other.inertia is not None
        assert one.inertia.mass == pytest.approx(other.inertia.mass, rel=1e-5)
        np.testing.assert_allclose(
            apply(one.pose, one.inertia.center), apply(other.pose, other.inertia.center), atol=1e-5 * size
        )
        eigen = [np.linalg.eigvalsh(tensor(b)) for b in (one, other)]
        np.testing.assert_allclose(eigen[0], eigen[1], rtol=1e-4)


@pytest.mark.parametrize("said", PLACES[::3], ids=str)
def test_a_prim_of_a_file_is_a_mesh_of_a_spec(tmp_path: Path, said: dict[str, Any]) -> None:
    """In metres, z up, in the prim's own frame: where it is in its file is left out, how it is scaled is not."""
    written(tmp_path, "mesh.usda", **said)
    found = body(tmp_path, 'object a { file: "mesh.usda#/World/thing/form"  scale: 0.5  at: (0, 0, 2 m) }')
    scale, meters = np.array(said["scale"], float), float(said["meters"])
    made = solid(found)
    assert made.volume == pytest.approx(abs(scale.prod()) * (0.5 * meters * 2) ** 3, rel=1e-5)
    middle = made.bounds.mean(axis=0)
    np.testing.assert_allclose(middle, (0, 0, 2), atol=1e-6)
    np.testing.assert_allclose(sorted(np.ptp(made.bounds, axis=0)), sorted(abs(scale) * meters), rtol=1e-5)


def test_a_skewed_mesh_is_where_it_is_in_its_file(tmp_path: Path) -> None:
    """A turn between two scales skews: no place and scale of a frame could say it, but points can."""
    inner = 'double xformOp:rotateZ = 45\nuniform token[] xformOpOrder = ["xformOp:rotateZ"]'
    mesh = f'def Mesh "form" ( prepend apiSchemas = ["PhysicsCollisionAPI"] ) {{\n{quads()}\n{inner}\n}}'
    outer = 'double3 xformOp:scale = (3, 1, 1)\nuniform token[] xformOpOrder = ["xformOp:scale"]'
    stretched = f'def Xform "stretched" {{\n{outer}\n{mesh}\n}}'
    top = f'def Xform "b" ( prepend apiSchemas = ["PhysicsRigidBodyAPI"] ) {{\n{stretched}\n}}'
    (tmp_path / "skew.usda").write_text(f'#usda 1.0\n(\nupAxis = "Z"\nmetersPerUnit = 1\n)\n{top}')
    made = solid(body(tmp_path, 'object a { file: "skew.usda"  at: (0, 0, 0) }'))
    assert made.volume == pytest.approx(24, rel=1e-5)
    reach = np.sqrt(2)
    np.testing.assert_allclose(made.bounds, [(-3 * reach, -reach, -1), (3 * reach, reach, 1)], atol=1e-5)


def test_holes_are_holes(tmp_path: Path) -> None:
    written(tmp_path, "mesh.usda", form=quads() + "\nint[] holeIndices = [0, 1]")
    (geom,) = (g for g in body(tmp_path, 'object a { file: "mesh.usda"  at: (0, 0, 0) }').geoms if g.visible)
    assert isinstance(geom.shape, Mesh)
    assert len(geom.shape.faces) == 8
    assert np.ptp(geom.shape.points, axis=0) == pytest.approx((2, 2, 2))


# ---------------------------------------------------------------- how it is touched

#: An L of two boxes' outline, extruded: not convex.
ANGLE = """point3f[] points = [(0,0,0),(2,0,0),(2,1,0),(1,1,0),(1,2,0),(0,2,0),
(0,0,1),(2,0,1),(2,1,1),(1,1,1),(1,2,1),(0,2,1)]
int[] faceVertexCounts = [4,4,4,4,4,4,4,4,4,4]
int[] faceVertexIndices = [0,3,2,1, 0,5,4,3, 6,7,8,9, 6,9,10,11,
0,1,7,6, 1,2,8,7, 2,3,9,8, 3,4,10,9, 4,5,11,10, 5,0,6,11]"""
WAYS = ("convexHull", "convexDecomposition", "boundingCube", "boundingSphere")


def ways(folder: Path, text: str) -> list[str]:
    """How the meshes of the object `a` are touched, as the stage says."""
    from wmspec.compile.design.design import Design
    from wmspec.compile.stage.episode import document

    task = spec(text, folder)
    prims = document(task, Design(task)[0]).prims
    found = (
        p.attributes.get("physics:approximation") for path, p in prims.items() if path.startswith("/World/Objects")
    )
    return [str(a.value) for a in found if a is not None]


@pytest.mark.parametrize("way", WAYS)
def test_mesh_collides_as_its_file_or_spec_defines(tmp_path: Path, way: str) -> None:
    written(tmp_path, "mesh.usda", form=ANGLE, way=way)
    assert ways(tmp_path, 'object a { file: "mesh.usda"  at: (0, 0, 0) }') == [way]
    for said in ("collision: bounds", "part thing { collision: bounds }"):
        assert ways(tmp_path, f'object a {{ file: "mesh.usda"  at: (0, 0, 0)  {said} }}') == ["boundingCube"]


def test_convex_mesh_is_its_own_hull(tmp_path: Path) -> None:
    written(tmp_path, "mesh.usda", way="none")
    assert ways(tmp_path, 'object a { file: "mesh.usda"  at: (0, 0, 0) }') == ["convexHull"]


def test_static_body_collides_with_its_exact_shape(tmp_path: Path) -> None:
    solid = 'prepend apiSchemas = ["PhysicsCollisionAPI"]'
    still = f'def Mesh "stand" ( {solid} ) {{\n{ANGLE}\n}}'
    free = 'def Sphere "ball" ( prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"] ) { }'
    joint = 'def PhysicsSphericalJoint "j" {\nrel physics:body0 = </stand>\nrel physics:body1 = </ball>\n}'
    head = '(\nupAxis = "Z"\nmetersPerUnit = 1\n)'
    (tmp_path / "both.usda").write_text(f"#usda 1.0\n{head}\n{still}\n{free}\n{joint}")
    assert ways(tmp_path, 'object a { file: "both.usda"  at: (0, 0, 0) }') == ["none"]


@pytest.mark.parametrize("way", ["none", "meshSimplification", "sdf"])
def test_movable_body_without_collision_is_reported(tmp_path: Path, way: str) -> None:
    written(tmp_path, "mesh.usda", form=ANGLE, way=way)
    for strict, severity in (("", "warning"), ("strict: true", "error")):
        (tmp_path / "spec.wms").write_text(
            f'task t : custom {{ object a {{ file: "mesh.usda"  at: (0, 0, 0) {strict} }} }}'
        )
        (reported,) = (d for d in checked(tmp_path / "spec.wms")[1].diagnostics if d.code == "WMS211")
        assert reported.severity == severity
        assert "`/World/thing/form`" in reported.message
        assert "its convex pieces" in reported.message
        assert reported.help is not None
        assert "collision" in reported.help
    assert ways(tmp_path, 'object a { file: "mesh.usda"  at: (0, 0, 0)  collision: hull }') == ["convexHull"]
