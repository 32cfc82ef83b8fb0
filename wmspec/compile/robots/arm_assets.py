"""Arms in USD files: `write_arm` converts a description, `read_arm` reads such a file."""

from __future__ import annotations

import json
from dataclasses import fields
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Sdf, Tf, Usd, UsdGeom, UsdPhysics

from wmspec.compile.layout.meshes import load
from wmspec.compile.robots.arm import Arm, Array, translation
from wmspec.compile.robots.description import ArmModel, read_description
from wmspec.compile.robots.links import articulate, body, box, finger, material, mesh_prim, pad
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.lang.importers.model import MeshFile, Shape
from wmspec.sim.scene.model.transform import apply
from wmspec.sim.shapes.facets import tessellate

ROOT, GREY, DARK = "/arm", (0.8, 0.8, 0.82), (0.25, 0.25, 0.27)
KEY = "wms:arm"
"""Key of the layer's metadata that holds the parameters of the arm, as JSON."""


def write_arm(path: Path, target: Path) -> ArmModel:
    """Write the arm that a TOML file describes as a USD file. Raises WmsError for invalid descriptions."""
    made = read_description(path)
    arm = made.arm
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, ROOT).GetPrim())
    *frames, hand = arm.links(arm.rest, np.eye(4))
    for i, frame in enumerate(frames[:-1]):
        _add_visuals(stage, body(stage, f"{ROOT}/link{i}", frame, moves=i > 0), made, i, np.eye(4))
    _add_visuals(
        stage,
        body(stage, f"{ROOT}/hand", hand, moves=True),
        made,
        len(frames) - 1,
        np.asarray(np.linalg.inv(arm.hand), np.float64),
    )
    _add_hand(stage, arm, hand)
    articulate(stage, ROOT, arm)
    for prim in stage.Traverse():
        if prim.HasAPI(UsdPhysics.RigidBodyAPI):
            UsdPhysics.RigidBodyAPI(prim).CreateKinematicEnabledAttr(True)
        elif prim.IsA(UsdPhysics.Joint):
            UsdPhysics.Joint(prim).CreateJointEnabledAttr(False)
    layer = stage.GetRootLayer()
    layer.customLayerData = {KEY: json.dumps({f.name: _to_json(getattr(arm, f.name)) for f in fields(Arm)})}
    layer.Export(str(target))
    return made


def _add_visuals(stage: Usd.Stage, link: str, made: ArmModel, number: int, into: Array) -> None:
    """Add the visual geometry of a link below its prim, whose frame is `into`."""
    for i, (shape, pose) in enumerate(made.shapes[number]):
        points, faces = _triangles(shape, made.folder)
        moved = apply(pose, points) @ into[:3, :3].T + into[:3, 3]
        color = shape.look.color or GREY
        look = material(stage, ROOT, "color" + "".join(f"_{round(100 * part)}" for part in color), color)
        mesh_prim(stage, f"{link}/mesh{i}", moved, faces, look)


def _triangles(shape: Shape, folder: Path) -> tuple[Array, Any]:
    if isinstance(shape.form, MeshFile):
        x, y, z = shape.form.scale
        mesh = load(str(folder / shape.form.file), (x, y, z), "hull", solid=False)
        return mesh.points, mesh.faces
    facets = tessellate(shape.form)
    return facets.points, facets.faces


def _add_hand(stage: Usd.Stage, arm: Arm, hand: Array) -> None:
    """Add the palm, with collision, and two fingers with pads."""
    rubber, dark = material(stage, ROOT, "rubber", DARK, arm.rubber), material(stage, ROOT, "finger", DARK)
    UsdPhysics.CollisionAPI.Apply(box(stage, f"{ROOT}/hand/palm", arm.hull, rubber).GetPrim())
    for side, turn in (("left", 0.0), ("right", np.pi)):
        frame = hand @ finger(arm, turn) @ translation(0.0, arm.opening / 2, 0.0)
        link = body(stage, f"{ROOT}/{side}_finger", frame, moves=True)
        box(stage, f"{link}/box", arm.tip, dark)
        pad(stage, f"{link}/pad", arm, rubber)


def read_arm(path: Path) -> Arm:
    """Return the arm of a file that `write_arm` wrote. Raises ImpossibleValue for other files."""
    try:
        status = path.stat()
    except OSError as error:
        raise ImpossibleValue(f"{path} cannot be read: {error.strerror}") from None
    return _read_arm(path, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=16)
def _read_arm(path: Path, _changed: int, _size: int) -> Arm:
    try:
        layer = Sdf.Layer.OpenAsAnonymous(str(path))
        said = json.loads(layer.customLayerData[KEY])
        arrays = {f.name: _from_json(said[f.name]) for f in fields(Arm)}
        arm = Arm(**{**arrays, "asset": str(path.resolve())})
        arm.tool(arm.rest, np.eye(4))
    except (Tf.ErrorException, AttributeError, KeyError, TypeError, ValueError, IndexError):
        raise ImpossibleValue(f"{path} is no arm", help="create it with `wmspec import-arm DESCRIPTION.toml`") from None
    return arm


def _to_json(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else value


def _from_json(value: Any) -> Any:
    """Return a JSON value as a number, a text, a tuple of texts or an array."""
    if isinstance(value, list):
        return tuple(value) if value and isinstance(value[0], str) else np.array(value, np.float64)
    return value
