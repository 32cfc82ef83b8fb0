"""The drives of joints: PhysicsDriveAPI, in SI units and radians."""

from __future__ import annotations

import math
from collections.abc import Sequence

from pxr import Usd

from wmspec.scene.model import Drive
from wmspec.usd.frames import World
from wmspec.usd.prims import applied, refuse, value

DEGREES = math.radians(1)


def drive(prim: Usd.Prim, name: str, world: World, free: Sequence[str] = ()) -> Drive | None:
    """The drive `name` (angular, linear, or a degree of freedom such as rotX), or None if it has none; of a ball joint,
    whose drives have no name, there may be none. `free` are all the names that the joint's drives may have.

    Raises:
        StageError: if it drives a ball joint or something that the joint does not leave free, or by acceleration.
    """
    driven = [api.partition(":")[2] for api in applied(prim) if api.startswith("PhysicsDriveAPI:")]
    names = _called(name)
    known = names.union(*map(_called, free))
    strange = [other for other in driven if other not in known and drives(prim, other)]
    if strange and not name:
        refuse(prim, f"its drive '{strange[0]}' is of a ball joint", "remove that PhysicsDriveAPI, or use hinges")
    if strange:
        refuse(prim, f"its drive '{strange[0]}' is of no axis that it leaves free", "remove that PhysicsDriveAPI")
    mine = next((other for other in driven if other in names), None)
    if mine is None or not drives(prim, mine):
        return None
    if value(prim, f"drive:{mine}:physics:type", "force") != "force":
        reason = "drives by acceleration are not supported"
        refuse(prim, reason, f"author drive:{mine}:physics:type = force, and a stiffness and damping for the masses")
    turns = mine == "angular" or mine.startswith("rot")
    length = world.meters
    way = DEGREES if turns else length
    force = world.kilograms * length * (length if turns else 1.0)
    number = {what: float(value(prim, f"drive:{mine}:physics:{what}", 0.0)) for what in _NUMBERS}
    most = float(value(prim, f"drive:{mine}:physics:maxForce", math.inf))
    return Drive(
        stiffness=number["stiffness"] * force / way,
        damping=number["damping"] * force / way,
        target=number["targetPosition"] * way,
        velocity=number["targetVelocity"] * way,
        max_force=most * force if most < 1e30 else math.inf,
    )


def _called(name: str) -> set[str]:
    return {name, {"rot": "angular", "tra": "linear"}.get(name[:3], name)}


_NUMBERS = ("stiffness", "damping", "targetPosition", "targetVelocity")


def drives(prim: Usd.Prim, name: str) -> bool:
    """Whether the drive does anything."""
    return any(value(prim, f"drive:{name}:physics:{what}", 0.0) for what in ("stiffness", "damping"))
