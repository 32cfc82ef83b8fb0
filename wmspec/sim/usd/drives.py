"""Joint drives: PhysicsDriveAPI, in SI units and radians."""

from __future__ import annotations

import math
from collections.abc import Sequence

from pxr import Usd

from wmspec.sim.scene.model import Drive
from wmspec.sim.usd.frames import StageFrame
from wmspec.sim.usd.prims import applied_schemas, refuse, value
from wmspec.sim.usd.substitutions import STRICT, Substitutions

DEGREES = math.radians(1)


def drive(
    prim: Usd.Prim, name: str, world: StageFrame, free: Sequence[str] = (), notes: Substitutions = STRICT
) -> Drive | None:
    """Return the drive `name` (angular, linear, or a degree of freedom such as rotX), or None.

    `free` are the valid names for this joint; a ball joint has none.

    Raises: StageError: if it drives a ball joint or a locked axis; with strict substitutions, also for acceleration
    drives.
    """
    driven = [api.partition(":")[2] for api in applied_schemas(prim) if api.startswith("PhysicsDriveAPI:")]
    names = _called(name)
    known = names.union(*map(_called, free))
    strange = [other for other in driven if other not in known and has_drive(prim, other)]
    if strange and not name:
        refuse(prim, f"its drive '{strange[0]}' belongs to a ball joint", "remove that PhysicsDriveAPI, or use hinges")
    if strange:
        reason = f"its drive '{strange[0]}' is on a locked axis"
        notes.record(prim, reason, "left out", "remove that PhysicsDriveAPI")
    mine = next((other for other in driven if other in names), None)
    if mine is None or not has_drive(prim, mine):
        return None
    weightless = value(prim, f"drive:{mine}:physics:type", "force") != "force"
    if weightless:
        remedy = f"author drive:{mine}:physics:type = force, and a stiffness and damping for the masses"
        notes.record(prim, "drives by acceleration are not supported", "a force drive for its initial load", remedy)
    turns = mine == "angular" or mine.startswith("rot")
    length = world.meters
    way = DEGREES if turns else length
    greatest = world.kilograms * length * (length if turns else 1.0)
    force = greatest if not weightless else 1.0 if turns else length
    number = {what: float(value(prim, f"drive:{mine}:physics:{what}", 0.0)) for what in _NUMBERS}
    most = float(value(prim, f"drive:{mine}:physics:maxForce", math.inf))
    return Drive(
        stiffness=number["stiffness"] * force / way,
        damping=number["damping"] * force / way,
        target=number["targetPosition"] * way,
        velocity=number["targetVelocity"] * way,
        max_force=most * greatest if most < 1e30 else math.inf,
        weightless=weightless,
    )


def _called(name: str) -> set[str]:
    return {name, {"rot": "angular", "tra": "linear"}.get(name[:3], name)}


_NUMBERS = ("stiffness", "damping", "targetPosition", "targetVelocity")


def has_drive(prim: Usd.Prim, name: str) -> bool:
    """Whether the drive has an effect."""
    return any(value(prim, f"drive:{name}:physics:{what}", 0.0) for what in ("stiffness", "damping"))
