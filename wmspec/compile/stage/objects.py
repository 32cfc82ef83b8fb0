"""Objects as prims: a frame for each, with its geometries, mass and material."""

from __future__ import annotations

import math

from wmspec.compile.layout import assets
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.layout.geometry import all_pieces, pieces, touchable
from wmspec.compile.layout.placement import frame
from wmspec.compile.layout.solids import PlacedShape, bounds
from wmspec.compile.layout.surfaces import support_faces
from wmspec.compile.stage import masses, materials
from wmspec.compile.stage.document import Document, Prim
from wmspec.core.diagnostics import ImpossibleValue
from wmspec.core.space import IDENTITY, IDENTITY_QUAT, UP, Pose, Vector, rotate, scale
from wmspec.lang.check.tables.vocabulary import COLLISIONS
from wmspec.lang.check.types import units
from wmspec.sim.shapes.polygons import Polygons


def object_path(name: str) -> str:
    """Return the path of an object's prim."""
    return f"/World/Objects/{name}"


def add_object(doc: Document, name: str, values: Evaluator, carriers: frozenset[str], carried: bool) -> None:
    """Add the prims of a present object; `carriers` are the sources of `carried`, whether actions carry it."""
    fixed, solid = values.flag(name, "fixed"), values.flag(name, "solid")
    if fixed and carried:
        raise ImpossibleValue(
            f"`{name}` is fixed, so nothing can carry it", values.source_location(name), "let it be `fixed: false`"
        )
    if not fixed and not carried and not solid:
        what = f"`{name}` cannot be touched, so it would fall through everything"
        raise ImpossibleValue(
            what, values.source_location(name), "make it `fixed: true`, or carry it with `glide` or `follow`"
        )
    require_support(name, values)
    weighed = () if fixed or not solid or not masses.has_own_mass(name, values) else ("PhysicsMassAPI",)
    passed = _pass_through_objects(name, values)
    filters = ("PhysicsFilteredPairsAPI",) if passed else ()
    belt = values.has(name, "surface_velocity")
    schemas = filters if fixed and not belt else ("PhysicsRigidBodyAPI", *weighed, *filters)
    if belt:
        schemas = (*schemas, "PhysxSurfaceVelocityAPI")
    body = doc.add(object_path(name), "Xform", schemas, (f"{name}.fixed", f"{name}.present"))
    pose = values.pose(name)
    body.set("xformOp:translate", "double3", pose.position, f"{name}.pose")
    body.set("xformOp:orient", "quatd", pose.orientation, f"{name}.pose")
    body.set("xformOpOrder", "token[]", ("xformOp:translate", "xformOp:orient"), uniform=True)
    if carriers and not fixed:
        body.set("physics:kinematicEnabled", "bool", carried, f"{name}.fixed", f"{name}.solid", *carriers)
    if belt:
        _set_surface_velocity(body, name, values)
    if values.has(name, "damping"):
        spun = "spin_damping" if values.has(name, "spin_damping") else "damping"
        for kind, word in (("linear", "damping"), ("angular", spun)):
            body.set(f"physxRigidBody:{kind}Damping", "float", values.number(name, word), f"{name}.{word}")
    _set_velocities(body, name, values)
    if passed:
        others = tuple(object_path(other) for other in passed)
        body.relate("physics:filteredPairs", others, f"{name}.passes", *(f"{other}.present" for other in passed))
    if weighed:
        masses.add_own_mass(body, name, values)
    _pieces(doc, name, values, solid)


def _set_velocities(body: Prim, name: str, values: Evaluator) -> None:
    """Set the initial velocities; those of an asset's link are along the asset's axes."""
    base = assets.base(values, name)
    turned = frame(values, base).orientation if base else IDENTITY_QUAT
    for word, attribute, unit in (("velocity", "velocity", 1.0), ("spin", "angularVelocity", 180 / math.pi)):
        if not values.has(name, word):
            continue
        if values.flag(name, "fixed"):
            place = values.source_location(name, word)
            raise ImpossibleValue(f"`{name}` is fixed, so it has no `{word}`", place, "let it be `fixed: false`")
        way = scale(unit, rotate(turned, values.vector(name, word)))
        body.set(f"physics:{attribute}", "vector3f", way, f"{name}.{word}", *((f"{base}.pose",) if base else ()))


def _set_surface_velocity(body: Prim, name: str, values: Evaluator) -> None:
    """Set the velocity of the surface of a belt, along its own axes: it is kinematic and stays where it is."""
    place = values.source_location(name, "surface_velocity")
    if not values.flag(name, "fixed"):
        what = f"`{name}` has a `surface_velocity` and is not fixed"
        raise ImpossibleValue(what, place, "make it `fixed: true`: a belt stays, and carries what touches it")
    if not values.flag(name, "solid"):
        raise ImpossibleValue(f"`{name}` cannot be touched, so its surface carries nothing", place)
    body.set("physics:kinematicEnabled", "bool", True, f"{name}.fixed")
    way = values.vector(name, "surface_velocity")
    body.set("physxSurfaceVelocity:surfaceVelocity", "vector3f", way, f"{name}.surface_velocity")


def _pass_through_objects(name: str, values: Evaluator) -> tuple[str, ...]:
    """Return the present objects that it does not collide with."""
    passes = values.references(name, "passes") if values.has(name, "passes") else ()
    return tuple(other for other in passes if other != name and values.is_present(other))


def _pieces(doc: Document, name: str, values: Evaluator, solid: bool) -> None:
    made = all_pieces(values, name)
    for part, piece in made:
        form = "mesh" if values.has(part, "file") else values.text(part, "shape")
        below = form if part == name else part.removeprefix(f"{name}.")
        touched = solid and touchable(values, part)
        prim = _piece(doc, f"{object_path(name)}/{below}", piece, part, name, values, touched)
        if touchable(values, part):
            masses.add_mass(prim, name, piece.solid.volume, values)
        prim.relate("material:binding", materials.add_material(doc, part, name, values))


def geometry(doc: Document, path: str, piece: PlacedShape, schemas: tuple[str, ...], sources: tuple[str, ...]) -> Prim:
    """Add the prim of a solid with its pose in the object; the first of the `sources` determines its form."""
    made, form = piece.solid.prim(), sources[0]
    prim = doc.add(path, made.type, (*schemas, "MaterialBindingAPI"), sources)
    if isinstance(made, Polygons):
        _place(prim, piece.pose, None, form)
        _mesh(prim, made, form)
    else:
        _place(prim, piece.pose.compose(Pose(made.offset)), made.scale, form)
        for attribute, type, value, uniform in made.attributes:
            prim.set(attribute, type, value, form, uniform=uniform)
        prim.set("extent", "float3[]", made.extent, form)
    return prim


def _piece(doc: Document, path: str, piece: PlacedShape, part: str, name: str, values: Evaluator, solid: bool) -> Prim:
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
            place = values.source_location(part, "collision")
            raise ImpossibleValue("only fixed objects can collide as a surface", place, "make it `hull` or `pieces`")
        prim.set("physics:approximation", "token", way, form, uniform=True)
    return prim


def _place(prim: Prim, pose: Pose, scale: Vector | None, form: str) -> None:
    """Set the pose of the prim in its object; nothing for the identity."""
    ops: list[tuple[str, str, tuple[float, ...]]] = []
    if pose != IDENTITY:
        ops += [("translate", "double3", pose.position), ("orient", "quatd", pose.orientation)]
    if scale is not None:
        ops.append(("scale", "double3", scale))
    for kind, type, value in ops:
        prim.set(f"xformOp:{kind}", type, value, form)
    if ops:
        prim.set("xformOpOrder", "token[]", tuple(f"xformOp:{kind}" for kind, _, _ in ops), form, uniform=True)


def _mesh(prim: Prim, made: Polygons, form: str) -> None:
    """Set the mesh of the prim."""
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


def require_support(name: str, values: Evaluator) -> None:
    """Raise WmsError with its location if an object that rests on another is beside it, in the air.

    Both count as their axis-aligned boxes; a ball on a level top counts as its contact point.
    """
    if not values.has(name, "on"):
        return
    base = values.reference(name, "on")
    made, pose = assets.pieces(values, name), frame(values, name) if name in values.assets else values.pose(name)
    low, high = bounds(made, pose)
    if len(made) == 1 and made[0].solid.symmetry == "ball" and support_faces(values, base)[0].normal == UP:
        low = high = pose.compose(made[0].pose).position
    least, most = values.memoized((base, "upright box"), lambda: bounds(pieces(values, base), values.pose(base)))
    if any(low[i] > most[i] + 1e-9 or high[i] < least[i] - 1e-9 for i in range(2)):
        word = "scatter" if values.has(name, "scatter") else "at"
        size = " by ".join(units.format_quantity(most[i] - least[i], units.LENGTH) for i in range(2))
        raise ImpossibleValue(
            f"`{name}` is in the air beside `{base}`, on which it should rest and which is {size} large",
            values.source_location(name, word),
            "move it there, or leave `on:` out and say `at: (x, y, z)`",
        )
