"""Builds an arm as a USD file: kinematic links connected by disabled joints; the hand has collision geometry."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade, Vt

from wmspec.compile.robots.arm import MAX_PAD_LENGTH, Arm, Array, axis_rotation, translation
from wmspec.sim.scene.model.transform import quaternion
from wmspec.sim.shapes.facets import smooth


def body(stage: Usd.Stage, path: str, frame: Array, *, moves: bool) -> str:
    """Add a link with its frame; return its path."""
    link = UsdGeom.Xform.Define(stage, path)
    link.AddTranslateOp().Set(Gf.Vec3d(*frame[:3, 3].tolist()))
    link.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Quatd(*quaternion(frame[:3, :3]).tolist()))
    if moves:
        UsdPhysics.RigidBodyAPI.Apply(link.GetPrim())
    return str(link.GetPath())


def mesh_prim(
    stage: Usd.Stage, path: str, points: Array, faces: NDArray[np.int32], look: UsdShade.Material
) -> UsdGeom.Mesh:
    """Add a triangle mesh with smooth normals; unused points are omitted."""
    facets = smooth(np.asarray(points, np.float64), np.asarray(faces, np.int32), None)
    used, corners = np.unique(facets.faces, return_inverse=True)
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.asarray(facets.points[used], np.float32)))
    mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(np.asarray(facets.normals[used], np.float32)))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    mesh.CreateFaceVertexCountsAttr([3] * len(facets.faces))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(corners.reshape(-1).astype(np.int32)))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateExtentAttr(UsdGeom.PointBased.ComputeExtent(mesh.GetPointsAttr().Get()))
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(look)
    return mesh


def pad(stage: Usd.Stage, path: str, arm: Arm, look: UsdShade.Material) -> None:
    """Add the invisible pad at the end of a finger, its collision geometry."""
    box = UsdGeom.Cube.Define(stage, path)
    box.CreateSizeAttr(1.0)
    box.CreateExtentAttr([(-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)])
    box.AddTranslateOp().Set(Gf.Vec3d(0.0, arm.pad / 2, arm.reach - arm.finger))
    box.AddScaleOp().Set(Gf.Vec3f(arm.width, arm.pad, min(MAX_PAD_LENGTH, arm.tip[1, 2])))
    box.CreateVisibilityAttr(UsdGeom.Tokens.invisible)
    UsdPhysics.CollisionAPI.Apply(box.GetPrim())
    UsdShade.MaterialBindingAPI.Apply(box.GetPrim()).Bind(look)


def material(
    stage: Usd.Stage, root: str, name: str, color: tuple[float, ...], friction: float | None = None
) -> UsdShade.Material:
    """Return a material with a colour, and with friction if given."""
    path = Sdf.Path(f"{root}/Looks/{name}")
    if existing := UsdShade.Material.Get(stage, path):
        return existing
    UsdGeom.Scope.Define(stage, f"{root}/Looks")
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


def finger(arm: Arm, turn: float) -> Array:
    """Return the frame in which a finger slides, in the hand's frame."""
    return translation(0.0, 0.0, arm.finger) @ axis_rotation(2, turn)


def articulate(stage: Usd.Stage, root: str, arm: Arm) -> None:
    """Add the joints of an arm under their names; the last hinge moves the hand."""
    last = len(arm.frames)
    for i, name in enumerate(arm.joints[:last], 1):
        hinge = UsdPhysics.RevoluteJoint.Define(stage, f"{root}/{name}")
        ends = (f"{root}/link{i - 1}", f"{root}/hand" if i == last else f"{root}/link{i}")
        below = np.asarray(np.linalg.inv(arm.hand), np.float64) if i == last else np.eye(4)
        limits = float(np.degrees(arm.low[i - 1])), float(np.degrees(arm.high[i - 1]))
        join(hinge, ends, arm.frames[i - 1], below, "Z", *limits)
    for name, side, turn in zip(arm.joints[last:], ("left", "right"), (0.0, np.pi), strict=True):
        slider = UsdPhysics.PrismaticJoint.Define(stage, f"{root}/{name}")
        ends = (f"{root}/hand", f"{root}/{side}_finger")
        join(slider, ends, finger(arm, turn), np.eye(4), "Y", 0.0, arm.opening / 2)


def join(
    joint: UsdPhysics.RevoluteJoint | UsdPhysics.PrismaticJoint,
    ends: tuple[str, str],
    above: Array,
    below: Array,
    axis: str,
    low: float,
    high: float,
) -> None:
    """Set the bodies, frames and limits of a joint."""
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


def box(stage: Usd.Stage, path: str, corners: Array, look: UsdShade.Material) -> UsdGeom.Cube:
    """Add a box between two corners (2, 3)."""
    made = UsdGeom.Cube.Define(stage, path)
    made.CreateSizeAttr(1.0)
    made.CreateExtentAttr([(-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)])
    made.AddTranslateOp().Set(Gf.Vec3d(*corners.mean(axis=0).tolist()))
    made.AddScaleOp().Set(Gf.Vec3f(*(corners[1] - corners[0]).tolist()))
    UsdShade.MaterialBindingAPI.Apply(made.GetPrim()).Bind(look)
    return made
