"""Position and velocity actuators of MuJoCo and Newton stages, read as drives of their joints.

A stage has no controls, so every control is 0, as in a simulation that nobody steers. Schemas: `MjcActuator` of
mjcPhysics (MuJoCo), `NewtonActuator` of newton-usd-schemas.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace

from pxr import Usd

from wmspec.core.diagnostics import Report
from wmspec.sim.scene.joints.servos import SHARED_LIMIT, UnsupportedActuator, combined, servo, shares_limit
from wmspec.sim.scene.model import Drive, Joint
from wmspec.sim.usd.prims import applied_schemas, targets, value
from wmspec.sim.usd.substitutions import STRICT, Substitutions

TYPES = ("MjcActuator", "NewtonActuator")
"""Prim types of actuators that are read."""

_REMEDY = "use a PhysicsDriveAPI, or remove it"
_GAINS = ("fixed", "affine")
_NEWTON_CLAMPS = ("NewtonDCMotorClampingAPI", "NewtonPositionBasedClampingAPI", "NewtonActuatorDelayAPI")


def with_actuators(
    prims: Iterable[Usd.Prim], joints: Mapping[str, Joint], problems: Report, notes: Substitutions = STRICT
) -> dict[str, Joint]:
    """Return the joints by path with the drives of their actuators; other actuators are recorded and left out."""
    made = dict(joints)
    left_out: dict[str, list[Usd.Prim]] = {}
    shared: list[Usd.Prim] = []
    for prim in prims:
        try:
            path, own = _mujoco(prim) if prim.GetTypeName() == "MjcActuator" else _newton(prim)
            if path not in made or made[path].kind not in ("hinge", "slider"):
                raise UnsupportedActuator("of no hinge or slider of a dynamic body is not supported")
            drive = combined(made[path].drive, own)
            if shares_limit(made[path].drive, own):
                shared.append(prim)
            made[path] = replace(made[path], drive=drive)
        except UnsupportedActuator as error:
            left_out.setdefault(str(error), []).append(prim)
    kinds = [(f"an actuator {reason}", those, "left out") for reason, those in left_out.items()]
    for what, those, instead in (*kinds, *([(SHARED_LIMIT, shared, "it limits their sum")] if shared else [])):
        others = f" (here and on {len(those) - 1} other prims)" if len(those) > 1 else ""
        with problems.collect_errors():
            notes.record(those[0], f"{what}{others}", instead, _REMEDY)
    return made


def _mujoco(prim: Usd.Prim) -> tuple[str, Drive]:
    """Return the joint and the drive of an `MjcActuator` with control 0: force = b0 + b1 length + b2 velocity."""
    if value(prim, "mjc:dynType", "none") not in ("none", "filter", "filterexact", "integrator"):
        raise UnsupportedActuator("with dynamics of its own is not supported")
    gain, bias = ((*value(prim, f"mjc:{name}Prm", ()), 0.0, 0.0, 0.0)[:3] for name in ("gain", "bias"))
    if value(prim, "mjc:biasType", "none") != "affine" or value(prim, "mjc:gainType", "fixed") not in _GAINS:
        raise UnsupportedActuator("that is no position or velocity actuator needs a control")
    gear = float((*value(prim, "mjc:gear", (1.0,)), 1.0)[0])
    force = _range(prim, "force") if value(prim, "mjc:forceLimited", "auto") != "false" else None
    control = _range(prim, "ctrl") if value(prim, "mjc:ctrlLimited", "auto") != "false" else None
    return _joint(prim, "mjc:target"), servo(gain[0], bias, gear, control, force)


def _range(prim: Usd.Prim, name: str) -> tuple[float, float] | None:
    low, high = (float(value(prim, f"mjc:{name}Range:{end}", 0.0)) for end in ("min", "max"))
    return (low, high) if low < high else None


def _newton(prim: Usd.Prim) -> tuple[str, Drive]:
    """Return the joint and the drive of a `NewtonActuator` with control 0."""
    apis = [api.partition(":")[0] for api in applied_schemas(prim)]
    if "NewtonPDControlAPI" not in apis and not any(prim.GetAttribute(f"newton:{n}") for n in ("kp", "kd")):
        raise UnsupportedActuator("without NewtonPDControlAPI is not supported")
    if clamp := next((api for api in apis if api in _NEWTON_CLAMPS), ""):
        raise UnsupportedActuator(f"with {clamp} is not supported")
    kp, kd, effort = (float(value(prim, f"newton:{name}", 0.0)) for name in ("kp", "kd", "constEffort"))
    if min(kp, kd) < 0 or not (kp or kd):
        raise UnsupportedActuator("that pushes away from its target, or needs a control, is not supported")
    most = float(value(prim, "newton:maxEffort", math.inf))
    target, speed = (effort / kp, 0.0) if kp else (0.0, effort / kd)
    return _joint(prim, "newton:targets"), Drive(kp, kd, target, speed, most if most > 0 else math.inf)


def _joint(prim: Usd.Prim, name: str) -> str:
    paths = targets(prim, name)
    if len(paths) != 1:
        raise UnsupportedActuator(f"with {len(paths)} targets is not supported")
    return paths[0]
