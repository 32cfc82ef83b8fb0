"""What a stage may hold and the engines are not given, and what it lacks: refused, never skipped."""

from __future__ import annotations

from collections.abc import Sequence

from pxr import Usd, UsdGeom

from wmspec.core.diagnostics import Report
from wmspec.sim.usd.files import text_of
from wmspec.sim.usd.frames import operations
from wmspec.sim.usd.prims import applied, present, refuse
from wmspec.sim.usd.substitutions import STRICT, Notes

_GEAR = ("gears and tendons are not supported", "remove it, or let a joint mimic another")
_SOFT = ("particles and deformable bodies are not supported", "deactivate the prim")
_SHAPE = ("this kind of geometry is not supported", "use a Cube, Sphere, Cylinder, Cone, Capsule or Mesh")
_VEHICLE = ("vehicles are not supported", "deactivate the prim")
_LAMP = ("only a DistantLight and a DomeLight are supported", "deactivate the light")

SEEN = {
    **dict.fromkeys(("Points", "BasisCurves", "NurbsCurves", "HermiteCurves", "NurbsPatch", "TetMesh"), _SHAPE),
    **{f"{kind}Light": _LAMP for kind in ("Sphere", "Rect", "Disk", "Cylinder", "Geometry", "Portal", "Plugin")},
    "DomeLight_1": ("DomeLight_1 is not supported", "use a DomeLight"),
    "PointInstancer": ("point instancers are not supported", "author each instance as a prim of its own"),
    "SkelRoot": ("skeletons are not supported", "deactivate the prim"),
    "Volume": _SHAPE,
}
"""Type of prim -> reason and remedy, of what can be left out of pictures, as long as physics has no part in it."""

TYPES = {
    **SEEN,
    **{f"PhysxPhysics{kind}Joint": _GEAR for kind in ("Gear", "RackAndPinion")},
    "PhysxParticleSystem": _SOFT,
    "PhysxParticleInstancer": _SOFT,
}
"""Type of prim -> reason and remedy."""

APIS = {
    "PhysxTendon": _GEAR,
    "PhysxSDFMeshCollisionAPI": ("colliders made of signed distance fields are not supported", "use convexHull"),
    "PhysxTriggerAPI": ("trigger volumes are not supported", "remove PhysxTriggerAPI"),
    "PhysxForceAPI": ("force fields are not supported", "remove PhysxForceAPI"),
    "PhysxSurfaceVelocityAPI": ("conveyors are not supported", "remove PhysxSurfaceVelocityAPI"),
    "PhysxParticle": _SOFT,
    "PhysxDeformable": _SOFT,
    "PhysxAutoParticle": _SOFT,
    "PhysxVehicle": _VEHICLE,
    "PhysicsDeformable": _SOFT,
    "PhysicsVolumeDeformable": _SOFT,
    "PhysicsSurfaceDeformable": _SOFT,
}
"""Beginning of an applied API schema's name -> reason and remedy."""

_STARTS = tuple(APIS)
_BINDINGS = ("material:binding", "material:binding:preview", "material:binding:physics")


def incomplete(stage: Usd.Stage, problems: Report) -> None:
    """Note the references, payloads, layers and the like that are not found, by prim, as USD tells them."""
    for error in sorted(stage.GetCompositionErrors(), key=str):  # USD finds them in any order
        with problems.gathered():
            prim = stage.GetPrimAtPath(error.rootSite.path) or stage.GetPseudoRoot()
            refuse(prim, " ".join(text_of(error).split()).rstrip("."), "mend the path, or remove what is not there")


def examine(prim: Usd.Prim, apis: Sequence[str], notes: Notes = STRICT) -> None:
    """Refuse a prim, with its applied schemas, that asks for something the engines are not given or that is not there.

    Raises:
        StageError: naming the prim, the reason and the remedy.
    """
    kind = str(prim.GetTypeName())
    if kind in SEEN and not _physical(prim):
        reason, remedy = SEEN[kind]
        notes.instead(prim, reason, "left out of pictures", remedy)
    elif row := TYPES.get(kind):
        refuse(prim, *row)
    for api in apis:
        if api.startswith(_STARTS):
            refuse(prim, *next(row for start, row in APIS.items() if api.startswith(start)))
    for binding in _BINDINGS:
        present(prim, binding, notes)
    operations(prim)
    if (place := UsdGeom.Xformable(prim)) and place.TransformMightBeTimeVarying():
        refuse(prim, "its transform is animated", "author one transform without time samples; move it by a WmsAction")


def _physical(prim: Usd.Prim) -> bool:
    """Whether the prim, or one below it, is more than something to see."""
    return any(api.startswith(("Physics", "Physx", "Newton")) for each in Usd.PrimRange(prim) for api in applied(each))
