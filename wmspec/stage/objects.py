"""Objects as prims: a frame for each, and below it the geometries that it is made of, with mass and material."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

from wmspec.check.vocabulary import TALL
from wmspec.diagnostics import ImpossibleValue
from wmspec.layout.geometry import every_piece, touchable
from wmspec.layout.solids import SLAB, Piece, Solid
from wmspec.layout.support import supported
from wmspec.layout.values import Values
from wmspec.space import HERE
from wmspec.stage import masses, materials, polygons
from wmspec.stage.document import Document, Prim

if TYPE_CHECKING:
    from wmspec.layout.meshes import Mesh

#: What a shape is in USD; a wedge and the mesh of a file are meshes.
PRIMS = {
    "box": "Cube",
    "cube": "Cube",
    "plane": "Cube",
    "sphere": "Sphere",
    "cylinder": "Cylinder",
    "cone": "Cone",
    "capsule": "Capsule",
}
_APPROXIMATIONS = {"hull": "convexHull", "pieces": "convexDecomposition", "bounds": "boundingCube"}


def object_path(name: str) -> str:
    """Where the prim of an object is."""
    return f"/World/Objects/{name}"


def add_object(doc: Document, name: str, values: Values, carriers: frozenset[str], carried: bool) -> None:
    """The prims of an object that is there; `carriers` are the sources of `carried`, whether actions carry it."""
    fixed, solid = values.property(name, "fixed"), values.property(name, "solid")
    if fixed and carried:
        raise ImpossibleValue(f"`{name}` is fixed, so nothing can carry it", values.place(name))
    if not fixed and not solid:
        raise ImpossibleValue(f"`{name}` cannot be touched, so it must be fixed", values.place(name))
    supported(name, values)
    weighed = () if fixed or not masses.own(name, values) else ("PhysicsMassAPI",)
    schemas = () if fixed else ("PhysicsRigidBodyAPI", *weighed)
    body = doc.add(object_path(name), "Xform", schemas, (f"{name}.fixed", f"{name}.present"))
    pose = values.pose(name)
    body.set("xformOp:translate", "double3", pose.position, f"{name}.pose")
    body.set("xformOp:orient", "quatd", pose.orientation, f"{name}.pose")
    body.set("xformOpOrder", "token[]", ("xformOp:translate", "xformOp:orient"), uniform=True)
    if carriers and not fixed:
        body.set("physics:kinematicEnabled", "bool", carried, *carriers)
    if values.has(name, "damping"):
        for kind in ("linear", "angular"):
            share = values.property(name, "damping")
            body.set(f"physxRigidBody:{kind}Damping", "float", share, f"{name}.damping")
    if weighed:
        masses.add_own(body, name, values)
    _pieces(doc, name, values, solid)


def _pieces(doc: Document, name: str, values: Values, solid: bool) -> None:
    made = every_piece(values, name)
    for part, piece in made:
        below = piece.solid.kind if part == name else part.removeprefix(f"{name}.")
        touched = solid and touchable(values, part)
        prim = _piece(doc, f"{object_path(name)}/{below}", piece, part, name, values, touched)
        if touchable(values, part):
            masses.add_mass(prim, name, piece.solid.volume, values)
        prim.relate("material:binding", materials.add_material(doc, part, name, values))


def _piece(doc: Document, path: str, piece: Piece, part: str, name: str, values: Values, solid: bool) -> Prim:
    made = piece.solid
    touched = ("PhysicsCollisionAPI", "PhysicsMassAPI") if solid else ()
    meshed = ("PhysicsMeshCollisionAPI",) if solid and made.kind not in PRIMS else ()
    sources = (f"{part}.form", f"{name}.solid", f"{name}.present")
    prim = doc.add(path, PRIMS.get(made.kind, "Mesh"), (*touched, *meshed, "MaterialBindingAPI"), sources)
    form, ops = f"{part}.form", []
    position, orientation = piece.pose.position, piece.pose.orientation
    if made.kind == "plane":
        position = piece.pose.apply((0.0, 0.0, -SLAB / 2))
    if piece.pose != HERE or made.kind == "plane":
        ops += [_op(prim, "translate", "double3", position, form), _op(prim, "orient", "quatd", orientation, form)]
    if PRIMS.get(made.kind) == "Cube":
        ops.append(_op(prim, "scale", "double3", made.edges, form))
    if ops:
        prim.set("xformOpOrder", "token[]", tuple(ops), form, uniform=True)
    _shape(prim, made, form)
    if values.has(part, "drawn") and not values.property(part, "drawn"):
        prim.set("visibility", "token", "invisible", f"{part}.drawn")
    if meshed:
        way = _APPROXIMATIONS[values.property(part, "collision")] if values.has(part, "file") else "convexHull"
        prim.set("physics:approximation", "token", way, form, uniform=True)
    return prim


def _op(prim: Prim, kind: str, type: str, value: tuple[float, ...], source: str) -> str:
    prim.set(f"xformOp:{kind}", type, value, source)
    return f"xformOp:{kind}"


def _shape(prim: Prim, made: Solid, form: str) -> None:
    x, y, z = made.edges
    corner = (x / 2, y / 2, z / 2)
    if made.kind == "mesh":
        polygons.of_mesh(cast("Mesh", made.hull)).give(prim, form)
        return
    if made.kind == "wedge":
        polygons.wedge(x, y, z).give(prim, form)
        return
    if PRIMS[made.kind] == "Cube":
        prim.set("size", "double", 1.0, form)
        corner = (0.5, 0.5, 0.5)
    else:
        prim.set("radius", "double", x / 2, form)
    if made.kind in TALL:
        prim.set("height", "double", z - x if made.kind == "capsule" else z, form)
        prim.set("axis", "token", "Z", form, uniform=True)
    prim.set("extent", "float3[]", (tuple(-c for c in corner), corner), form)
