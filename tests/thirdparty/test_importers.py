"""MuJoCo's and Newton's importers see the bodies, masses and frames that our reader sees."""

from __future__ import annotations

import json
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd, UsdPhysics

from tests.thirdparty.environments import python_with, run
from wmspec.sim.scene.model import Body
from wmspec.sim.shapes import Cone, Lathe
from wmspec.sim.usd import read

HERE = Path(__file__).parent
IMPORTERS = {
    "mujoco": (f"mujoco[usd]=={version('mujoco')}",),
    "newton": ("newton==1.8.0", "newton-usd-schemas", "usd-core", "scipy"),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", IMPORTERS)
def test_an_importer_sees_our_bodies(name: str, catalogue: dict[str, list[Path]], tmp_path: Path) -> None:
    stages = [str(paths[1]) for paths in catalogue.values() if name == "newton" or mujoco_reads(paths[1])]
    assert stages
    printed = run(python_with(*IMPORTERS[name]), HERE / f"bodies_in_{name}.py", *stages, folder=tmp_path)
    found = json.loads(printed.splitlines()[-1])
    wrong = [said for stage in stages for said in differences(read(Usd.Stage.Open(stage)).bodies, found[stage])]
    assert wrong == []


def mujoco_reads(path: Path) -> bool:
    """Whether MuJoCo's importer reads all shapes: it leaves out cones, and takes hollow meshes for their hulls."""
    stage = Usd.Stage.Open(str(path))
    meshes = [UsdPhysics.MeshCollisionAPI(p) for p in stage.Traverse() if p.HasAPI(UsdPhysics.MeshCollisionAPI)]
    hollow = any(mesh.GetApproximationAttr().Get() == UsdPhysics.Tokens.convexDecomposition for mesh in meshes)
    return not hollow and not any(isinstance(geom.shape, Cone) for body in read(stage).bodies for geom in body.geoms)


def differences(bodies: tuple[Body, ...], found: dict[str, Any]) -> Iterator[str]:
    """What an importer sees otherwise, prim by prim."""
    moving = [body for body in bodies if body.motion != "static"]
    if set(found) != {body.path for body in moving}:
        yield f"bodies: {sorted(found)}"
        return
    for body in moving:
        # We take the round volume of a lathe, and split it into convex pieces; importers see a mesh.
        has_lathe = any(isinstance(geom.shape, Lathe) for geom in body.geoms)
        tolerance = 1e-2 if has_lathe else 1e-4
        for key, ours in properties(body).items():
            if has_lathe and key == "friction":
                continue
            theirs = np.array(found[body.path][key])
            if key == "orientation" and theirs @ ours < 0:
                theirs = -theirs
            if theirs.shape != np.shape(ours) or not np.allclose(theirs, ours, rtol=tolerance, atol=1e-6):
                yield f"{body.path}: {key} is {theirs.tolist()}, ours {np.asarray(ours).tolist()}"


def properties(body: Body) -> dict[str, Any]:
    """The same properties as the importers print; masses of dynamic bodies only."""
    found: dict[str, Any] = {"position": body.pose.position, "orientation": body.pose.orientation}
    if body.inertia is not None:
        found |= {"mass": body.inertia.mass, "center": body.inertia.center, "moments": np.sort(body.inertia.moments)}
        found |= {"friction": [geom.friction.dynamic for geom in body.geoms if geom.collides]}
    return found
