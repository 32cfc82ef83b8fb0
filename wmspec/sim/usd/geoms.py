"""Geoms of a body: placement, appearance, friction, collision and visible shapes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from pxr import Sdf, Usd, UsdShade

from wmspec.core.diagnostics import StageError
from wmspec.sim.scene.model import Friction, Geom, Pose, Surface
from wmspec.sim.shapes import Shape
from wmspec.sim.usd import materials, meshes
from wmspec.sim.usd.prims import Names, applied_schemas
from wmspec.sim.usd.shapes import PlacedShape
from wmspec.sim.usd.stage_index import GeomPrim
from wmspec.sim.usd.substitutions import STRICT, Substitutions


class MaterialTable:
    """Materials of geoms and mesh subsets, resolved once for all.

    Roughness and metalness from textures are refused, or ignored if `pictured`.
    """

    def __init__(self, pieces: Iterable[GeomPrim], *, pictured: bool = False, notes: Substitutions = STRICT) -> None:
        self._notes = notes
        prims = [p for piece in pieces for p in (piece.prim, *_subsets(piece.prim))]
        paths = [prim.GetPath() for prim in prims]
        self._look = dict(zip(paths, materials.bound_materials(prims, "preview"), strict=True))
        self._physics = dict(zip(paths, materials.bound_materials(prims, "physics"), strict=True))
        self._pictured = pictured
        self._surfaces: dict[tuple[Sdf.Path, str], Surface | None] = {}
        self._frictions: dict[Sdf.Path | None, Friction] = {}

    def surface(self, prim: Usd.Prim) -> Surface | None:
        """Return the appearance of a geom or subset; None if nothing defines it."""
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
            self._notes.record_error(error, "a plain colour is used")
            return materials.surface(prim, None)

    def friction(self, prim: Usd.Prim) -> Friction:
        """Return the friction of a geom."""
        material = self._physics[prim.GetPath()]
        key = material.GetPath() if material else None
        if key not in self._frictions:
            self._frictions[key] = materials.friction(material)
        return self._frictions[key]

    def density(self, prim: Usd.Prim) -> float:
        """Return the density from the physics material of a geom, or 0."""
        return materials.density(self._physics[prim.GetPath()])

    def alike(self, prim: Usd.Prim) -> None:
        """Refuse a subset whose physics material differs from that of its mesh."""
        for subset in _subsets(prim):
            own = self._physics[subset.GetPath()]
            if own is None or "PhysicsMaterialAPI" not in applied_schemas(own):
                continue
            if (self.friction(subset), self.density(subset)) != (self.friction(prim), self.density(prim)):
                reason = (
                    f"its physics material {own.GetPath()} differs from that of its mesh, which collides as a whole"
                )
                remedy = "bind one physics material to the mesh, or split the mesh"
                self._notes.record(subset, reason, "the material of the mesh is used", remedy)


def geoms(
    piece: GeomPrim,
    placed: PlacedShape,
    touched: Sequence[tuple[Shape, Pose]],
    name: str,
    names: Names,
    materials: MaterialTable,
) -> list[Geom]:
    """Return the geom `name` with its collision shapes; subsets that look different are drawn in its place.

    Raises: StageError: if its collider or appearance is not supported, or its subsets differ in friction.
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
