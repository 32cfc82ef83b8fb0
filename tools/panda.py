"""Create `wmspec/compile/robots/panda/panda.usdc` from PyBullet's meshes of the Franka Panda (Apache-2.0).

Run `python -m tools.panda` in the root of the checkout; it needs `pybullet` and `fast-simplification`. The meshes are
joined by colour and decimated; the last link and the hand are one body. The joints are disabled, since actions move the
links kinematically; with enabled joints, the arm is an articulation.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import fast_simplification
import numpy as np
import pybullet_data
import trimesh
from pxr import Gf, Usd, UsdGeom, UsdPhysics, UsdShade

from wmspec.compile.robots.arm import Array, translation
from wmspec.compile.robots.franka import PANDA
from wmspec.compile.robots.links import articulate, body, finger, material, mesh_prim, pad

SOURCE = Path(pybullet_data.getDataPath()) / "franka_panda"
TARGET = Path("wmspec/compile/robots/panda")
KEPT = 0.12  # of the triangles
ROUGH = 300  # triangles: below that nothing is taken away
#: Stiffness and damping of each joint, N m/rad and N m s/rad; of the fingers N/m and N s/m.
DRIVES = (*[(600.0, 50.0)] * 4, *[(60.0, 3.0)] * 3, *[(100.0, 8.0)] * 2)
#: Mass (kg) and centre of mass (m) of each link, from panda.urdf; the hand is part of the last link.
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
    rubber = material(stage, "/panda", "rubber", (0.2, 0.2, 0.2), PANDA.rubber)
    frames = PANDA.links(PANDA.rest, np.eye(4))
    frames = [*frames[:-2], frames[-1]]
    for i, frame in enumerate(frames):
        name = "hand" if i == len(frames) - 1 else f"link{i}"
        link = body(stage, f"/panda/{name}", frame, moves=i > 0)
        drawn = ["hand", "link7"] if name == "hand" else [name]
        meshes(stage, link, [(mesh, np.linalg.inv(PANDA.hand) if mesh == "link7" else np.eye(4)) for mesh in drawn])
    hull(stage, "/panda/hand/hull", "hand", rubber)
    for side, turn in (("left", 0.0), ("right", np.pi)):
        frame = finger(PANDA, turn)
        link = body(
            stage, f"/panda/{side}_finger", frames[-1] @ frame @ translation(0.0, PANDA.opening / 2, 0.0), moves=True
        )
        meshes(stage, link, [("finger", np.eye(4))])
        pad(stage, f"{link}/pad", PANDA, rubber)
    articulate(stage, "/panda", PANDA)
    motion(stage)
    stage.GetRootLayer().Save()
    shutil.copy(SOURCE / "LICENSE.txt", TARGET / "LICENSE.txt")
    (TARGET / "NOTICE").write_text(NOTICE)


def motion(stage: Usd.Stage) -> None:
    """Add the variants of `motion`: kinematic links, and an articulation with masses and drives that hold it still."""
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
    """Add the masses, drives and articulation root of the second variant."""
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
    """Return the moments (kg m²) of a solid box around the visible shape of a link; only its mass is known."""
    corners = [
        np.array(UsdGeom.Mesh(mesh).GetExtentAttr().Get()) for mesh in link.GetChildren() if mesh.IsA(UsdGeom.Mesh)
    ]
    edges = np.max(corners, axis=(0, 1)) - np.min(corners, axis=(0, 1))
    return [float(mass * (np.sum(edges**2) - edge**2) / 12) for edge in edges]


def meshes(stage: Usd.Stage, link: str, names: list[tuple[str, Array]]) -> None:
    """Write the visible meshes of a link, one per colour, in its frame."""
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
        mesh_prim(
            stage, f"{link}/mesh{i}", points, faces, material(stage, "/panda", f"color{color_name(color)}", color)
        )


def color_name(color: tuple[float, ...]) -> str:
    """Return a colour as part of a name."""
    return "".join(f"_{round(100 * c)}" for c in color)


def hull(stage: Usd.Stage, path: str, name: str, look: UsdShade.Material) -> None:
    """Write the invisible convex hull of the hand's collision mesh."""
    whole = trimesh.load(SOURCE / f"meshes/collision/{name}.obj", force="mesh").convex_hull
    mesh = mesh_prim(stage, path, whole.vertices, whole.faces, look)
    mesh.CreateVisibilityAttr(UsdGeom.Tokens.invisible)
    UsdPhysics.CollisionAPI.Apply(mesh.GetPrim())
    UsdPhysics.MeshCollisionAPI.Apply(mesh.GetPrim()).CreateApproximationAttr(UsdPhysics.Tokens.convexHull)


if __name__ == "__main__":
    main()
