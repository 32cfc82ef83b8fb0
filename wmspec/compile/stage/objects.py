"""Objects as prims: a frame for each, and below it the geometries that it is made of, with mass and material."""

from __future__ import annotations

import math

from wmspec.compile.layout import assets
from wmspec.compile.layout.geometry import every_piece, touchable
from wmspec.compile.layout.placement import frame
from wmspec.compile.layout.solids import Piece
from wmspec.compile.layout.support import supported
from wmspec.compile.layout.values import Values
from wmspec.compile.stage import masses, materials
from wmspec.compile.stage.document import Document, Prim
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import HERE, LEVEL, Pose, Vector, rotate, times
from wmspec.lang.check.tables.vocabulary import COLLISIONS
from wmspec.sim.shapes.polygons import Polygons


def object_path(name: str) -> str:
    """Where the prim of an object is."""
    return f"/World/Objects/{name}"


def add_object(doc: Document, name: str, values: Values, carriers: frozenset[str], carried: bool) -> None:
    """The prims of an object that is there; `carriers` are the sources of `carried`, whether actions carry it."""
    fixed, solid = values.flag(name, "fixed"), values.flag(name, "solid")
    if fixed and carried:
        raise ImpossibleValue(f"`{name}` is fixed, so nothing can carry it", values.place(name))
    if not fixed and not carried and not solid:
        what = f"`{name}` cannot be touched, so it would fall through everything"
        raise ImpossibleValue(what, values.place(name), "make it `fixed: true`, or carry it with `glide` or `follow`")
    supported(name, values)
    weighed = () if fixed or not solid or not masses.own(name, values) else ("PhysicsMassAPI",)
    passed = _passed(name, values)
    filters = ("PhysicsFilteredPairsAPI",) if passed else ()
    schemas = filters if fixed else ("PhysicsRigidBodyAPI", *weighed, *filters)
    body = doc.add(object_path(name), "Xform", schemas, (f"{name}.fixed", f"{name}.present"))
    pose = values.pose(name)
    body.set("xformOp:translate", "double3", pose.position, f"{name}.pose")
    body.set("xformOp:orient", "quatd", pose.orientation, f"{name}.pose")
    body.set("xformOpOrder", "token[]", ("xformOp:translate", "xformOp:orient"), uniform=True)
    if carriers and not fixed:
        body.set("physics:kinematicEnabled", "bool", carried, f"{name}.fixed", *carriers)
    if values.has(name, "damping"):
        spun = "spin_damping" if values.has(name, "spin_damping") else "damping"
        for kind, word in (("linear", "damping"), ("angular", spun)):
            body.set(f"physxRigidBody:{kind}Damping", "float", values.number(name, word), f"{name}.{word}")
    _moving(body, name, values)
    if passed:
        others = tuple(object_path(other) for other in passed)
        body.relate("physics:filteredPairs", others, f"{name}.passes", *(f"{other}.present" for other in passed))
    if weighed:
        masses.add_own(body, name, values)
    _pieces(doc, name, values, solid)


def _moving(body: Prim, name: str, values: Values) -> None:
    """How it moves at the start, which a link of an asset says along the axes of that."""
    base = assets.base(values, name)
    turned = frame(values, base).orientation if base else LEVEL
    for word, attribute, unit in (("velocity", "velocity", 1.0), ("spin", "angularVelocity", 180 / math.pi)):
        if not values.has(name, word):
            continue
        if values.flag(name, "fixed"):
            place = values.place(name, word)
            raise ImpossibleValue(f"`{name}` is fixed, so it has no `{word}`", place)
        way = times(unit, rotate(turned, values.vector(name, word)))
        body.set(f"physics:{attribute}", "vector3f", way, f"{name}.{word}", *((f"{base}.pose",) if base else ()))


def _passed(name: str, values: Values) -> tuple[str, ...]:
    """The objects that are there and that it passes through."""
    passes = values.references(name, "passes") if values.has(name, "passes") else ()
    return tuple(other for other in passes if other != name and values.there(other))


def _pieces(doc: Document, name: str, values: Values, solid: bool) -> None:
    made = every_piece(values, name)
    for part, piece in made:
        form = "mesh" if values.has(part, "file") else values.text(part, "shape")
        below = form if part == name else part.removeprefix(f"{name}.")
        touched = solid and touchable(values, part)
        prim = _piece(doc, f"{object_path(name)}/{below}", piece, part, name, values, touched)
        if touchable(values, part):
            masses.add_mass(prim, name, piece.solid.volume, values)
        prim.relate("material:binding", materials.add_material(doc, part, name, values))


def geometry(doc: Document, path: str, piece: Piece, schemas: tuple[str, ...], sources: tuple[str, ...]) -> Prim:
    """The prim of a solid where it is in its object; the first of the `sources` is what decides its form."""
    made, form = piece.solid.prim(), sources[0]
    prim = doc.add(path, made.type, (*schemas, "MaterialBindingAPI"), sources)
    if isinstance(made, Polygons):
        _place(prim, piece.pose, None, form)
        _mesh(prim, made, form)
    else:
        _place(prim, piece.pose.then(Pose(made.offset)), made.scale, form)
        for attribute, type, value, uniform in made.attributes:
            prim.set(attribute, type, value, form, uniform=uniform)
        prim.set("extent", "float3[]", made.extent, form)
    return prim


def _piece(doc: Document, path: str, piece: Piece, part: str, name: str, values: Values, solid: bool) -> Prim:
    mesh = isinstance(piece.solid.prim(), Polygons)
    touched = ("PhysicsCollisionAPI", "PhysicsMassAPI") if solid else ()
    meshed = ("PhysicsMeshCollisionAPI",) if solid and mesh else ()
    form = f"{part}.form"
    prim = geometry(doc, path, piece, (*touched, *meshed), (form, f"{name}.solid", f"{name}.present"))
    shown = dict.fromkeys((part, name))
    if not all(values.flag(owner, "drawn") for owner in shown if values.has(owner, "drawn")):
        prim.set("visibility", "token", "invisible", *(f"{owner}.drawn" for owner in shown))
    if meshed:
        way = "convexHull" if piece.solid.convex else "convexDecomposition"
        if values.has(part, "file"):
            way = COLLISIONS[values.text(part, "collision")]
        if way == "none" and not values.flag(name, "fixed"):
            place = values.place(part, "collision")
            raise ImpossibleValue("only what is fixed is touched as its surface", place, "make it `hull` or `pieces`")
        prim.set("physics:approximation", "token", way, form, uniform=True)
    return prim


def _place(prim: Prim, pose: Pose, scale: Vector | None, form: str) -> None:
    """Where the prim is in its object; nothing if that is where the object is."""
    ops: list[tuple[str, str, tuple[float, ...]]] = []
    if pose != HERE:
        ops += [("translate", "double3", pose.position), ("orient", "quatd", pose.orientation)]
    if scale is not None:
        ops.append(("scale", "double3", scale))
    for kind, type, value in ops:
        prim.set(f"xformOp:{kind}", type, value, form)
    if ops:
        prim.set("xformOpOrder", "token[]", tuple(f"xformOp:{kind}" for kind, _, _ in ops), form, uniform=True)


def _mesh(prim: Prim, made: Polygons, form: str) -> None:
    """Make the prim this mesh."""
    prim.set("points", "point3f[]", made.points, form)
    prim.set("faceVertexCounts", "int[]", made.counts, form)
    prim.set("faceVertexIndices", "int[]", made.indices, form)
    prim.set("subdivisionScheme", "token", "none", form, uniform=True)
    normals, varies = (made.normals, "uniform") if made.smooth is None else (made.smooth, "vertex")
    prim.set("primvars:normals", "normal3f[]", normals, form, varies=varies)
    prim.set("extent", "float3[]", made.extent, form)
    if made.st:
        prim.set("primvars:st", "texCoord2f[]", made.st, form, varies="vertex")
    for name, type, value in made.numbers:
        prim.set(name, type, value, form, uniform=True)
