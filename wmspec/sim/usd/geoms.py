"""The geometries of a body: where they are, how they look and rub, what collides and what is drawn."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from pxr import Sdf, Usd, UsdShade

from wmspec.core.diagnostics import StageError
from wmspec.sim.scene.model import Friction, Geom, Pose, Surface
from wmspec.sim.shapes import Shape
from wmspec.sim.usd import materials, meshes
from wmspec.sim.usd.prims import Names, applied
from wmspec.sim.usd.shapes import Placed
from wmspec.sim.usd.stage_index import Piece
from wmspec.sim.usd.substitutions import STRICT, Notes


class Materials:
    """What the geometries, and the subsets of meshes among them, are made of: looked up once for all.

    Roughness and metalness that are pictures are refused, or else, if they may be `pictured`, not honoured.
    """

    def __init__(self, pieces: Iterable[Piece], *, pictured: bool = False, notes: Notes = STRICT) -> None:
        self._notes = notes
        prims = [p for piece in pieces for p in (piece.prim, *_subsets(piece.prim))]
        paths = [prim.GetPath() for prim in prims]
        self._look = dict(zip(paths, materials.bound(prims, "preview"), strict=True))
        self._physics = dict(zip(paths, materials.bound(prims, "physics"), strict=True))
        self._pictured = pictured
        self._surfaces: dict[tuple[Sdf.Path, str], Surface | None] = {}
        self._frictions: dict[Sdf.Path | None, Friction] = {}

    def surface(self, prim: Usd.Prim) -> Surface | None:
        """How the geometry or subset looks; None if nothing says it."""
        material = self._look[prim.GetPath()]
        of = prim.GetParent() if prim.GetTypeName() == "GeomSubset" else prim
        coordinates = meshes.coordinates(of) if of.GetTypeName() == "Mesh" else ""
        key = ((material or prim).GetPath(), coordinates)
        if key not in self._surfaces:
            self._surfaces[key] = self._shown(prim, material, coordinates or "st")
        return self._surfaces[key]

    def _shown(self, prim: Usd.Prim, material: Usd.Prim | None, st: str) -> Surface | None:
        try:
            return materials.surface(prim, material, st, pictured=self._pictured)
        except StageError as error:
            self._notes.rather(error, "it has a plain colour")
            return materials.surface(prim, None)

    def friction(self, prim: Usd.Prim) -> Friction:
        """How the geometry rubs."""
        material = self._physics[prim.GetPath()]
        key = material.GetPath() if material else None
        if key not in self._frictions:
            self._frictions[key] = materials.friction(material)
        return self._frictions[key]

    def density(self, prim: Usd.Prim) -> float:
        """The density that the geometry's physics material gives it, or 0."""
        return materials.density(self._physics[prim.GetPath()])

    def alike(self, prim: Usd.Prim) -> None:
        """Refuse a subset with a physics material of its own that says something else than that of its mesh."""
        for subset in _subsets(prim):
            own = self._physics[subset.GetPath()]
            if own is None or "PhysicsMaterialAPI" not in applied(own):
                continue
            if (self.friction(subset), self.density(subset)) != (self.friction(prim), self.density(prim)):
                reason = f"its physics material {own.GetPath()} is not that of its mesh, which collides as a whole"
                remedy = "bind one physics material to the mesh, or make two meshes of it"
                self._notes.instead(subset, reason, "all of it has that of the mesh", remedy)


def geoms(
    piece: Piece,
    placed: Placed,
    touched: Sequence[tuple[Shape, Pose]],
    name: str,
    names: Names,
    materials: Materials,
) -> list[Geom]:
    """The geometry `name`, with what collides for it; if its subsets look different, they are drawn instead of it.

    Raises:
        StageError: if its collider or its look is not supported, or its subsets rub in other ways.
    """
    prim = piece.prim
    friction = materials.friction(prim)
    if piece.collides:
        materials.alike(prim)
    drawn = []
    for part, faces in meshes.parts(prim) if piece.visible else []:
        shape, surface = meshes.mesh(prim, placed.place.stretch, faces), materials.surface(part) or Surface()
        drawn.append(
            Geom(names.give(f"{name}_{part.GetName()}"), shape, placed.pose, surface, friction, collides=False)
        )
    if drawn and not piece.collides:
        return drawn
    visible = piece.visible and not drawn
    surface = (materials.surface(prim) if visible else None) or Surface()
    if all(shape is placed.shape for shape, _ in touched):
        return [*drawn, Geom(name, placed.shape, placed.pose, surface, friction, piece.collides, visible)]
    if visible:
        drawn.append(Geom(name, placed.shape, placed.pose, surface, friction, collides=False))
    return drawn + [
        Geom(names.give(f"{name}_{i}"), shape, pose, Surface(), friction, visible=False)
        for i, (shape, pose) in enumerate(touched)
    ]


def _subsets(prim: Usd.Prim) -> list[Usd.Prim]:
    if prim.GetTypeName() != "Mesh":
        return []
    return [subset.GetPrim() for subset in UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets()]
