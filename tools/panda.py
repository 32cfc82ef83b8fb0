"""Makes `wmspec/robots/panda/panda.usdc` of the meshes of the Franka Panda that come with PyBullet (Apache-2.0).

Run it from the root: `python -m tools.panda`; it needs `pybullet` and `fast-simplification`. The meshes are joined by
colour and decimated; the last link and the hand are one body. The joints are disabled: the links move as actions say,
and whoever enables the joints has an articulation.
"""

from __future__ import annotations

import shutil
from math import degrees
from pathlib import Path

import fast_simplification
import numpy as np
import pybullet_data
import trimesh
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade, Vt

from wmspec.robots.arm import Array, about, shift
from wmspec.robots.franka import PANDA
from wmspec.scene.transform import quaternion
from wmspec.shapes.facets import smooth

SOURCE = Path(pybullet_data.getDataPath()) / "franka_panda"
TARGET = Path("wmspec/robots/panda")
KEPT = 0.12  # of the triangles
ROUGH = 300  # triangles: below that nothing is taken away
#: Of each joint, N m/rad and N m s/rad; of the fingers N/m and N s/m.
DRIVES = (*[(600.0, 50.0)] * 4, *[(60.0, 3.0)] * 3, *[(100.0, 8.0)] * 2)
#: What the links weigh (kg) and where the middle of that is (m), by panda.urdf; the hand is one with the last link.
MASSES = {
    "link1": (2.7, (0.0, -0.04, -0.05)),
    "link2": (2.73, (0.0, -0.04, 0.06)),
    "link3": (2.04, (0.01, 0.01, -0.05)),
    "link4": (2.08, (-0.03, 0.03, 0.02)),
    "link5": (3.0, (0.0, 0.04, -0.12)),
    "link6": (1.3, (0.04, 0.0, 0.0)),
    "hand": (1.01, (0.0, 0.0, 0.027)),
    "left_finger": (0.1, (0.0, 0.01, 0.02)),
    "right_finger": (0.1, (0.0, 0.01, 0.02)),
}
NOTICE = """Franka Emika Panda, from franka_description (https://github.com/frankaemika/franka_ros), Copyright 2017
Franka Emika GmbH, under the Apache License 2.0 (LICENSE.txt), as it comes with PyBullet (pybullet_data/franka_panda).
Changed by tools/panda.py: the meshes are joined by colour, decimated and written as USD, with disabled joints.
"""


def main() -> None:
    """Write the file, its licence and its notice."""
    stage = Usd.Stage.CreateNew(str(TARGET / "panda.usdc"))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    root = UsdGeom.Xform.Define(stage, "/panda")
    stage.SetDefaultPrim(root.GetPrim())
    rubber = material(stage, "rubber", (0.2, 0.2, 0.2), PANDA.rubber)
    frames = PANDA.links(PANDA.rest, np.eye(4))
    frames = [*frames[:-2], frames[-1]]
    for i, frame in enumerate(frames):
        name = "hand" if i == len(frames) - 1 else f"link{i}"
        link = body(stage, name, frame, moves=i > 0)
        drawn = ["hand", "link7"] if name == "hand" else [name]
        meshes(stage, link, [(mesh, np.linalg.inv(PANDA.hand) if mesh == "link7" else np.eye(4)) for mesh in drawn])
    hull(stage, "/panda/hand/hull", "hand", rubber)
    for side, turn in (("left", 0.0), ("right", np.pi)):
        frame = finger(turn)
        link = body(stage, f"{side}_finger", frames[-1] @ frame @ shift(0.0, PANDA.opening / 2, 0.0), moves=True)
        meshes(stage, link, [("finger", np.eye(4))])
        pad(stage, f"{link}/pad", rubber)
    for i, name in enumerate(PANDA.joints[:7]):
        last = i == 6
        low, high = degrees(PANDA.low[i]), degrees(PANDA.high[i])
        hinge = UsdPhysics.RevoluteJoint.Define(stage, f"/panda/{name}")
        ends = (f"/panda/link{i}", "/panda/hand" if last else f"/panda/link{i + 1}")
        join(hinge, ends, PANDA.frames[i], np.linalg.inv(PANDA.hand) if last else np.eye(4), "Z", low, high)
    for name, side, turn in zip(PANDA.joints[7:], ("left", "right"), (0.0, np.pi), strict=True):
        slider = UsdPhysics.PrismaticJoint.Define(stage, f"/panda/{name}")
        ends = ("/panda/hand", f"/panda/{side}_finger")
        join(slider, ends, finger(turn), np.eye(4), "Y", 0.0, PANDA.opening / 2)
    motion(stage)
    stage.GetRootLayer().Save()
    shutil.copy(SOURCE / "LICENSE.txt", TARGET / "LICENSE.txt")
    (TARGET / "NOTICE").write_text(NOTICE)


def motion(stage: Usd.Stage) -> None:
    """Two variants of `motion`: links that follow a plan, and a mechanism with masses and drives that hold it still."""
    root = stage.GetPrimAtPath("/panda")
    variants = root.GetVariantSets().AddVariantSet("motion")
    for variant in ("articulated", "planned"):  # the last one is chosen
        variants.AddVariant(variant)
        variants.SetVariantSelection(variant)
        with variants.GetVariantEditContext():
            for name in MASSES:
                link = UsdPhysics.RigidBodyAPI(stage.GetPrimAtPath(f"/panda/{name}"))
                link.CreateKinematicEnabledAttr(variant == "planned")
            for name in PANDA.joints:
                UsdPhysics.Joint(stage.GetPrimAtPath(f"/panda/{name}")).CreateJointEnabledAttr(variant == "articulated")
            if variant == "articulated":
                articulated(stage, root)


def articulated(stage: Usd.Stage, root: Usd.Prim) -> None:
    """What a mechanism has that nobody plans for: masses, drives, and that it is one."""
    UsdPhysics.ArticulationRootAPI.Apply(root)
    for name, (mass, center) in MASSES.items():
        link = stage.GetPrimAtPath(f"/panda/{name}")
        weighs = UsdPhysics.MassAPI.Apply(link)
        weighs.CreateMassAttr(mass)
        weighs.CreateCenterOfMassAttr(center)
        weighs.CreatePrincipalAxesAttr(Gf.Quatf(1))
        weighs.CreateDiagonalInertiaAttr(Gf.Vec3f(*moments(link, mass)))
    for i, name in enumerate(PANDA.joints):
        joint, turns = stage.GetPrimAtPath(f"/panda/{name}"), i < len(PANDA.rest)
        drive = UsdPhysics.DriveAPI.Apply(joint, "angular" if turns else "linear")
        drive.CreateTypeAttr("force")
        drive.CreateTargetPositionAttr(float(np.degrees(PANDA.rest[i])) if turns else PANDA.opening / 2)
        stiffness, damping = np.array(DRIVES[i]) * (np.pi / 180 if turns else 1.0)  # USD's angles are in degrees
        drive.CreateStiffnessAttr(float(stiffness))
        drive.CreateDampingAttr(float(damping))


def moments(link: Usd.Prim, mass: float) -> list[float]:
    """The moments (kg m²) of a solid box around what is drawn of a link: what is known is its mass alone."""
    corners = [
        np.array(UsdGeom.Mesh(mesh).GetExtentAttr().Get()) for mesh in link.GetChildren() if mesh.IsA(UsdGeom.Mesh)
    ]
    edges = np.max(corners, axis=(0, 1)) - np.min(corners, axis=(0, 1))
    return [float(mass * (np.sum(edges**2) - edge**2) / 12) for edge in edges]


def finger(turn: float) -> Array:
    """Where a finger slides, in the hand's frame."""
    return shift(0.0, 0.0, PANDA.finger) @ about(2, turn)


def body(stage: Usd.Stage, name: str, frame: Array, *, moves: bool) -> str:
    """A link at its place; the path of it."""
    link = UsdGeom.Xform.Define(stage, f"/panda/{name}")
    link.AddTranslateOp().Set(Gf.Vec3d(*frame[:3, 3].tolist()))
    link.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Quatd(*quaternion(frame[:3, :3]).tolist()))
    if moves:
        UsdPhysics.RigidBodyAPI.Apply(link.GetPrim())
    return str(link.GetPath())


def meshes(stage: Usd.Stage, link: str, names: list[tuple[str, Array]]) -> None:
    """The visible meshes of a link, one for each colour, in its frame."""
    by_color: dict[tuple[float, ...], list[trimesh.Trimesh]] = {}
    for name, frame in names:
        file = next(f for way in ("visual", "collision") if (f := SOURCE / f"meshes/{way}/{name}.obj").exists())
        loaded = trimesh.load(file)
        for mesh in loaded.geometry.values() if isinstance(loaded, trimesh.Scene) else [loaded]:
            mesh.apply_transform(frame)
            diffuse = getattr(getattr(mesh.visual, "material", None), "diffuse", None)
            color = (0.9, 0.92, 0.93) if diffuse is None else tuple(round(float(c) / 255, 2) for c in diffuse[:3])
            by_color.setdefault((0.96, 0.96, 0.96) if color == (1.0, 1.0, 1.0) else color, []).append(mesh)
    for i, (color, every) in enumerate(sorted(by_color.items())):
        whole = trimesh.util.concatenate([trimesh.Trimesh(m.vertices, m.faces) for m in every])
        whole.merge_vertices()
        points, faces = whole.vertices, whole.faces
        if len(faces) > ROUGH:
            points, faces = fast_simplification.simplify(points.astype(np.float32), faces, 1 - KEPT)
        mesh_prim(stage, f"{link}/mesh{i}", points, faces, material(stage, f"color{color_name(color)}", color))


def color_name(color: tuple[float, ...]) -> str:
    """A colour as part of a name."""
    return "".join(f"_{round(100 * c)}" for c in color)


def mesh_prim(stage: Usd.Stage, path: str, points: Array, faces: Array, look: UsdShade.Material) -> UsdGeom.Mesh:
    """A mesh of triangles with smooth normals."""
    facets = smooth(np.asarray(points, np.float64), np.asarray(faces, np.int32), None)
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.asarray(facets.points, np.float32)))
    mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(np.asarray(facets.normals, np.float32)))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    mesh.CreateFaceVertexCountsAttr([3] * len(facets.faces))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.asarray(facets.faces, np.int32).reshape(-1)))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateExtentAttr(UsdGeom.PointBased.ComputeExtent(mesh.GetPointsAttr().Get()))
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(look)
    return mesh


def hull(stage: Usd.Stage, path: str, name: str, look: UsdShade.Material) -> None:
    """What touches of the hand: the convex hull of its collision mesh, out of sight."""
    whole = trimesh.load(SOURCE / f"meshes/collision/{name}.obj", force="mesh").convex_hull
    mesh = mesh_prim(stage, path, whole.vertices, whole.faces, look)
    mesh.CreateVisibilityAttr(UsdGeom.Tokens.invisible)
    UsdPhysics.CollisionAPI.Apply(mesh.GetPrim())
    UsdPhysics.MeshCollisionAPI.Apply(mesh.GetPrim()).CreateApproximationAttr(UsdPhysics.Tokens.convexHull)


def pad(stage: Usd.Stage, path: str, look: UsdShade.Material) -> None:
    """What touches of a finger: the pad at its end, out of sight."""
    box = UsdGeom.Cube.Define(stage, path)
    box.CreateSizeAttr(1.0)
    box.CreateExtentAttr([(-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)])
    box.AddTranslateOp().Set(Gf.Vec3d(0.0, PANDA.pad / 2, PANDA.reach - PANDA.finger))
    box.AddScaleOp().Set(Gf.Vec3f(PANDA.width, PANDA.pad, 0.019))
    box.CreateVisibilityAttr(UsdGeom.Tokens.invisible)
    UsdPhysics.CollisionAPI.Apply(box.GetPrim())
    UsdShade.MaterialBindingAPI.Apply(box.GetPrim()).Bind(look)


def material(stage: Usd.Stage, name: str, color: tuple[float, ...], friction: float | None = None) -> UsdShade.Material:
    """A material that is a colour, and rubs if it has a friction."""
    path = Sdf.Path(f"/panda/Looks/{name}")
    if existing := UsdShade.Material.Get(stage, path):
        return existing
    UsdGeom.Scope.Define(stage, "/panda/Looks")
    made = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, path.AppendChild("surface"))
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*color))
    shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(0.4)
    made.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    if friction is not None:
        rubs = UsdPhysics.MaterialAPI.Apply(made.GetPrim())
        rubs.CreateStaticFrictionAttr(friction)
        rubs.CreateDynamicFrictionAttr(friction)
        rubs.CreateRestitutionAttr(0.0)
    return made


def join(
    joint: UsdPhysics.RevoluteJoint | UsdPhysics.PrismaticJoint,
    ends: tuple[str, str],
    above: Array,
    below: Array,
    axis: str,
    low: float,
    high: float,
) -> None:
    """What a joint holds, where and how far it goes."""
    joint.CreateBody0Rel().SetTargets([ends[0]])
    joint.CreateBody1Rel().SetTargets([ends[1]])
    for frame, place, turn in (
        (above, joint.CreateLocalPos0Attr(), joint.CreateLocalRot0Attr()),
        (below, joint.CreateLocalPos1Attr(), joint.CreateLocalRot1Attr()),
    ):
        place.Set(Gf.Vec3f(*frame[:3, 3].tolist()))
        turn.Set(Gf.Quatf(*quaternion(frame[:3, :3]).tolist()))
    joint.CreateAxisAttr(axis)
    joint.CreateLowerLimitAttr(low)
    joint.CreateUpperLimitAttr(high)


if __name__ == "__main__":
    main()
