"""The bodies of a scene: every rigid body of the stage, and every group of geometries that never moves."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
from pxr import Gf, Sdf, Usd

from wmspec.scene.model import Array, Body, Friction, Geom, Mesh, Pose, Shape, Surface
from wmspec.scene.read import looks, meshes
from wmspec.scene.read.frames import Place, World, split, vector
from wmspec.scene.read.masses import Collider, body_inertia
from wmspec.scene.read.prims import Problems, refuse, value
from wmspec.scene.read.shapes import shape
from wmspec.scene.read.walk import Owner, Piece

_HULLS = ("convexHull", "convexDecomposition", "meshSimplification", "none")


class Names:
    """Gives every path a name of its own: its last part if that is free."""

    def __init__(self) -> None:
        self._taken: set[str] = set()

    def give(self, *wishes: str) -> str:
        """The first wish that is free, or the last with a number; `/` becomes `_`."""
        plain = [wish.strip("/").replace("/", "_") for wish in wishes]
        numbered = (f"{plain[-1]}_{i}" for i in range(2, 2 + len(self._taken)))
        name = next(name for name in (*plain, *numbered, plain[-1]) if name not in self._taken)
        self._taken.add(name)
        return name


class Materials:
    """What the geometries, and the subsets of meshes among them, are made of: looked up once for all."""

    def __init__(self, pieces: Iterable[Piece]) -> None:
        prims = [p for piece in pieces for p in (piece.prim, *_subsets(piece.prim))]
        paths = [prim.GetPath() for prim in prims]
        self._look = dict(zip(paths, looks.bound(prims, "preview"), strict=True))
        self._physics = dict(zip(paths, looks.bound(prims, "physics"), strict=True))
        self._surfaces: dict[Sdf.Path, Surface] = {}
        self._frictions: dict[Sdf.Path | None, Friction] = {}

    def surface(self, prim: Usd.Prim) -> Surface:
        """How the geometry or subset looks."""
        material = self._look[prim.GetPath()]
        key = (material or prim).GetPath()
        if key not in self._surfaces:
            self._surfaces[key] = looks.surface(prim, material)
        return self._surfaces[key]

    def friction(self, prim: Usd.Prim) -> Friction:
        """How the geometry rubs."""
        material = self._physics[prim.GetPath()]
        key = material.GetPath() if material else None
        if key not in self._frictions:
            self._frictions[key] = looks.friction(material)
        return self._frictions[key]

    def density(self, prim: Usd.Prim) -> float:
        """The density that the geometry's physics material gives it, or 0."""
        return looks.density(self._physics[prim.GetPath()])


def bodies(owners: Sequence[Owner], world: World, problems: Problems) -> tuple[Body, ...]:
    """The bodies, in the stage's order; what is wrong with them goes to `problems`."""
    materials = Materials(piece for owner in owners for piece in owner.pieces)
    names, found = Names(), []
    for owner in owners:
        name = names.give(owner.prim.GetName(), str(owner.prim.GetPath()))
        with problems.gathered():
            found.append(_body(owner, name, world, materials))
    return tuple(found)


def _body(owner: Owner, name: str, world: World, materials: Materials) -> Body:
    prim, problems = owner.prim, Problems()
    place = split(world.matrix(prim), prim)
    inverse = place.rigid.GetInverse()
    names, geoms, colliders = Names(), [], []
    for piece in owner.pieces:
        with problems.gathered():
            local = split(world.matrix(piece.prim) * inverse, piece.prim)
            found, pose = shape(piece.prim, local)
            geoms += _geoms(piece, local, found, pose, names, str(prim.GetPath()), materials)
            if piece.collides:
                colliders.append(Collider(piece.prim, local, found, pose, materials.density(piece.prim)))
    problems.report()
    linear, angular = _velocities(owner, world)
    return Body(
        name,
        str(prim.GetPath()),
        owner.motion,
        place.pose,
        tuple(geoms),
        body_inertia(prim, place, colliders, world) if owner.motion == "dynamic" else None,
        linear,
        angular,
        float(value(prim, "physxRigidBody:linearDamping", 0.0)),
        float(value(prim, "physxRigidBody:angularDamping", 0.0)),
    )


def _geoms(
    piece: Piece, local: Place, found: Shape, pose: Pose, names: Names, body: str, materials: Materials
) -> list[Geom]:
    """The geometry; if its subsets look different, they are drawn instead of it."""
    prim, path = piece.prim, str(piece.prim.GetPath())
    if isinstance(found, Mesh) and piece.collides:
        _check_collider(prim, found)
    name = names.give(path.removeprefix(body) or prim.GetName(), path)
    friction = materials.friction(prim)
    pieces = meshes.parts(prim) if piece.visible and isinstance(found, Mesh) else []
    drawn = [
        Geom(
            names.give(f"{name}_{part.GetName()}"),
            meshes.mesh(prim, local.stretch, faces),
            pose,
            materials.surface(part),
            friction,
            collides=False,
        )
        for part, faces in pieces
    ]
    surface = materials.surface(prim) if piece.visible and not drawn else Surface()
    whole = Geom(name, found, pose, surface, friction, piece.collides, piece.visible and not drawn)
    return drawn + [whole] * (whole.collides or whole.visible)


def _check_collider(prim: Usd.Prim, found: Mesh) -> None:
    """A mesh collides as its convex hull: refuse one that was meant otherwise."""
    way = value(prim, "physics:approximation", "none")
    if way not in _HULLS:
        refuse(prim, f"the approximation '{way}' is not supported", "set physics:approximation to convexHull")
    if meshes.is_flat(found):
        refuse(prim, "a mesh that collides has no volume", "use a Cube, a Plane or a mesh that is not flat")
    if way != "convexHull" and not meshes.is_convex(found):
        remedy = "set physics:approximation to convexHull, or split it into convex meshes"
        refuse(prim, "a mesh that is not convex would collide as its convex hull", remedy)


def _velocities(owner: Owner, world: World) -> tuple[Array, Array]:
    """Linear (m/s) and angular (rad/s), from the space in which the prim's own transform is given, to the world."""
    linear = Gf.Vec3d(value(owner.prim, "physics:velocity", Gf.Vec3f(0)))
    angular = Gf.Vec3d(value(owner.prim, "physics:angularVelocity", Gf.Vec3f(0)))
    if owner.motion == "static" or not (any(linear) or any(angular)):
        return np.zeros(3), np.zeros(3)
    if owner.motion == "kinematic":
        refuse(owner.prim, "a kinematic body with a velocity is not supported", "move it by a WmsAction that glides")
    if not all(map(math.isfinite, (*linear, *angular))):
        refuse(owner.prim, "its velocity is not finite", "author a finite velocity")
    parent = world.parent(owner.prim)
    turn = split(parent, owner.prim).rigid
    return vector(parent.TransformDir(linear)), np.radians(vector(turn.TransformDir(angular)))


def _subsets(prim: Usd.Prim) -> list[Usd.Prim]:
    if prim.GetTypeName() != "Mesh":
        return []
    return [child for child in prim.GetChildren() if child.GetTypeName() == "GeomSubset"]
