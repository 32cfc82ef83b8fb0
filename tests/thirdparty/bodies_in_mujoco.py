"""Prints what MuJoCo's own importer makes of stages, as JSON: file -> prim of a body -> its properties."""

import json
import sys

import mujoco


def bodies(path: str) -> dict[str, dict[str, object]]:
    """Place, orientation (w, x, y, z), mass, centre of mass and principal moments of every body."""
    model = mujoco.MjSpec.from_file(path).compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)  # an arm is a tree to it
    return {
        model.body(i).name: {
            "position": data.xpos[i].tolist(),
            "orientation": data.xquat[i].tolist(),
            "mass": float(model.body_mass[i]),
            "center": model.body_ipos[i].tolist(),
            "moments": sorted(model.body_inertia[i].tolist()),
            "friction": [float(model.geom_friction[g, 0]) for g in range(model.ngeom) if model.geom_bodyid[g] == i],
        }
        for i in range(1, model.nbody)
    }


print(json.dumps({path: bodies(path) for path in sys.argv[1:]}))
