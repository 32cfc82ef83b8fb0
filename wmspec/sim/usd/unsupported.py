"""Unsupported contents of stages, and missing files: refused, never skipped."""

from __future__ import annotations

from collections.abc import Sequence

from pxr import Usd, UsdGeom

from wmspec.core.diagnostics import Report
from wmspec.core.limits import SCHEMAS
from wmspec.sim.usd.files import error_text
from wmspec.sim.usd.frames import operations
from wmspec.sim.usd.prims import applied_schemas, existing_targets, refuse
from wmspec.sim.usd.substitutions import STRICT, Substitutions

_GEAR = ("gears and tendons are not supported", "remove it, or let a joint mimic another")
_SOFT = ("particles and deformable bodies are not supported", "deactivate the prim")
_SHAPE = ("this kind of geometry is not supported", "use a Cube, Sphere, Cylinder, Cone, Capsule or Mesh")
_VEHICLE = ("vehicles are not supported", "deactivate the prim")
_LAMP = ("only a DistantLight and a DomeLight are supported", "deactivate the light")

VISUAL_ONLY = {
    **dict.fromkeys(("Points", "BasisCurves", "NurbsCurves", "HermiteCurves", "NurbsPatch", "TetMesh"), _SHAPE),
    **{f"{kind}Light": _LAMP for kind in ("Sphere", "Rect", "Disk", "Cylinder", "Geometry", "Portal", "Plugin")},
    "DomeLight_1": ("DomeLight_1 is not supported", "use a DomeLight"),
    "PointInstancer": ("point instancers are not supported", "author each instance as a prim of its own"),
    "SkelRoot": ("skeletons are not supported", "deactivate the prim"),
    "Volume": _SHAPE,
}
"""Prim type -> reason and remedy, for prims that pictures can omit if they have no physics."""

TYPES = {
    **VISUAL_ONLY,
    **{f"PhysxPhysics{kind}Joint": _GEAR for kind in ("Gear", "RackAndPinion")},
    "PhysxParticleSystem": _SOFT,
    "PhysxParticleInstancer": _SOFT,
}
"""Prim type -> reason and remedy."""

APIS = {
    "PhysxTendon": _GEAR,
    "PhysxSDFMeshCollisionAPI": ("colliders made of signed distance fields are not supported", "use convexHull"),
    "PhysxTriggerAPI": ("trigger volumes are not supported", "remove PhysxTriggerAPI"),
    "PhysxForceAPI": ("force fields are not supported", "remove PhysxForceAPI"),
    "PhysxParticle": _SOFT,
    "PhysxDeformable": _SOFT,
    "PhysxAutoParticle": _SOFT,
    "PhysxVehicle": _VEHICLE,
    "PhysicsDeformable": _SOFT,
    "PhysicsVolumeDeformable": _SOFT,
    "PhysicsSurfaceDeformable": _SOFT,
}
"""Prefix of an applied API schema -> reason and remedy."""

_STARTS = tuple(APIS)
_BINDINGS = ("material:binding", "material:binding:preview", "material:binding:physics")


def report_missing_files(stage: Usd.Stage, problems: Report) -> None:
    """Report references, payloads, layers and the like that are missing, by prim."""
    for error in sorted(stage.GetCompositionErrors(), key=str):  # USD reports them in arbitrary order
        with problems.collect_errors():
            prim = stage.GetPrimAtPath(error.rootSite.path) or stage.GetPseudoRoot()
            refuse(prim, " ".join(error_text(error).split()).rstrip("."), "fix the path or remove the reference")


def refuse_unsupported(prim: Usd.Prim, apis: Sequence[str], notes: Substitutions = STRICT) -> None:
    """Refuse a prim with unsupported type, schema or binding.

    Raises: StageError: with prim, reason and remedy.
    """
    kind = str(prim.GetTypeName())
    if len(apis) > SCHEMAS.most:
        refuse(prim, SCHEMAS.sentence, SCHEMAS.help)
    if kind in VISUAL_ONLY and not _physical(prim):
        reason, remedy = VISUAL_ONLY[kind]
        notes.record(prim, reason, "left out of pictures", remedy)
    elif row := TYPES.get(kind):
        refuse(prim, *row)
    for api in apis:
        if api.startswith(_STARTS):
            refuse(prim, *next(row for start, row in APIS.items() if api.startswith(start)))
    for binding in _BINDINGS:
        existing_targets(prim, binding, notes)
    operations(prim)
    if (place := UsdGeom.Xformable(prim)) and place.TransformMightBeTimeVarying():
        refuse(prim, "its transform is animated", "author one transform without time samples; move it by a WmsAction")


def _physical(prim: Usd.Prim) -> bool:
    """Whether the prim or a descendant takes part in physics."""
    return any(
        api.startswith(("Physics", "Physx", "Newton")) for each in Usd.PrimRange(prim) for api in applied_schemas(each)
    )
