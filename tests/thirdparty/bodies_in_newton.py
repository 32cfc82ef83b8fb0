"""Prints what Newton makes of stages, as JSON: file -> prim of a body -> its properties."""

import json
import sys

import newton
import numpy as np
import warp

warp.config.quiet = True


def bodies(path: str) -> dict[str, dict[str, object]]:
    """Place, orientation (w, x, y, z), mass, centre of mass and principal moments of every body."""
    builder = newton.ModelBuilder()
    builder.add_usd(path)
    found = {}
    for i, label in enumerate(builder.body_label):
        place = [float(x) for x in builder.body_q[i]]
        shapes = [s for s, body in enumerate(builder.shape_body) if body == i]
        found[label] = {
            "position": place[:3],
            "orientation": [place[6], *place[3:6]],
            "mass": float(builder.body_mass[i]),
            "center": [float(x) for x in builder.body_com[i]],
            "moments": sorted(np.linalg.eigvalsh(np.reshape(builder.body_inertia[i], (3, 3))).tolist()),
            "friction": [float(builder.shape_material_mu[s]) for s in shapes],
        }
    return found


print(json.dumps({path: bodies(path) for path in sys.argv[1:]}))
