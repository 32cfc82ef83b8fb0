"""One traversal of the stage that finds bodies with geoms, joints, cameras, lights and the episode."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from pxr import Kind, Usd, UsdGeom

from wmspec.core.diagnostics import Report
from wmspec.sim.scene.model import Motion
from wmspec.sim.usd.prims import applied_schemas, refuse, value
from wmspec.sim.usd.shapes import GEOMETRIES
from wmspec.sim.usd.substitutions import STRICT, Substitutions
from wmspec.sim.usd.unsupported import TYPES, VISUAL_ONLY, refuse_unsupported

_CLOSED = frozenset({"Material", "Shader", "NodeGraph"})
_FILTERS = frozenset({"PhysicsFilteredPairsAPI", "PhysicsArticulationRootAPI"})
_END = ("physics:body0", "physics:body1")
_DRAWN = ("default", "render")


@dataclass(frozen=True)
class GeomPrim:
    """A geom of a body."""

    prim: Usd.Prim
    collides: bool
    visible: bool


@dataclass(frozen=True)
class BodyPrim:
    """The prim of a body, and the geoms that move with it."""

    prim: Usd.Prim
    motion: Motion
    pieces: list[GeomPrim] = field(default_factory=list)


@dataclass
class StageIndex:
    """The contents of a stage, each kind in stage order."""

    owners: dict[str, BodyPrim] = field(default_factory=dict)
    others: dict[str, list[Usd.Prim]] = field(default_factory=dict)
    filters: list[Usd.Prim] = field(default_factory=list)
    joints: list[Usd.Prim] = field(default_factory=list)

    def of(self, kind: str) -> list[Usd.Prim]:
        """Return the non-geometry prims of a type."""
        return self.others.get(kind, [])


@dataclass(frozen=True)
class _Inherited:
    """Inherited state of a prim."""

    owner: BodyPrim | None = None
    visible: bool = True
    purpose: str = "default"
    collides: bool = False


class StageWalk:
    """Finds bodies and everything around them; unsupported prims go to `problems`.

    Prims of the types in `aside`, and everything below them, are skipped.
    """

    def __init__(
        self, stage: Usd.Stage, problems: Report, aside: frozenset[str] = frozenset(), notes: Substitutions = STRICT
    ) -> None:
        self.census = StageIndex()
        self._notes = notes
        self._closed = _CLOSED | aside
        self._problems = problems
        self._predicate = Usd.TraverseInstanceProxies()
        default = stage.GetDefaultPrim()
        self._objects = default.GetPath().AppendChild("Objects") if default else None
        for prim in stage.GetPseudoRoot().GetFilteredChildren(self._predicate):
            self._visit(prim, _Inherited())

    def _visit(self, prim: Usd.Prim, above: _Inherited) -> None:
        kind = str(prim.GetTypeName())
        if kind in self._closed:
            return
        apis = applied_schemas(prim)
        with self._problems.collect_errors():
            refuse_unsupported(prim, apis, self._notes)
            if not _FILTERS.isdisjoint(apis):
                self.census.filters.append(prim)
            if sight := UsdGeom.Imageable(prim):
                above = self._inherit(prim, sight, apis, above)
            if kind in GEOMETRIES:
                self._geometry(prim, apis, above)
            elif kind.startswith("Physics") and kind.endswith("Joint"):
                self.census.joints.append(prim)
            elif kind.endswith("Joint") and (prim.HasRelationship(_END[0]) or prim.HasRelationship(_END[1])):
                refuse(prim, f"joints of type {kind} are unknown", "use a joint of UsdPhysics, or deactivate it")
            elif "PhysicsCollisionAPI" in apis:
                above = self._group(prim, kind, above)
            else:
                self.census.others.setdefault(kind, []).append(prim)
        instanced = kind == "PointInstancer"  # prims below it have no place of their own
        if kind not in TYPES or (kind in VISUAL_ONLY and not self._notes.strict and not instanced):
            for child in prim.GetFilteredChildren(self._predicate):
                self._visit(child, above)

    def _group(self, prim: Usd.Prim, kind: str, above: _Inherited) -> _Inherited:
        """Mark geoms below a collider that is not a geom as colliders."""
        remedy = "apply PhysicsCollisionAPI to its geometries"
        self._notes.record(prim, f"a collider of type '{kind}' has no shape", "the geometries below it collide", remedy)
        return replace(above, collides=bool(value(prim, "physics:collisionEnabled", True)))

    def _inherit(self, prim: Usd.Prim, sight: UsdGeom.Imageable, apis: Sequence[str], above: _Inherited) -> _Inherited:
        visible = above.visible and value(prim, "visibility") != "invisible"
        purpose = sight.GetPurposeAttr()
        own = purpose.Get() if purpose.HasAuthoredValue() else above.purpose
        return _Inherited(self._owner(prim, apis, above.owner), visible, own, above.collides)

    def _owner(self, prim: Usd.Prim, apis: Sequence[str], owner: BodyPrim | None) -> BodyPrim | None:
        """Return the body of a prim: itself, an ancestor, or None."""
        if "PhysicsRigidBodyAPI" in apis:
            owner = BodyPrim(prim, _motion(prim))
            self.census.owners[str(prim.GetPath())] = owner
        elif owner is None and (prim.GetPath().GetParentPath() == self._objects or _is_component(prim)):
            owner = BodyPrim(prim, "static")
        return owner

    def _geometry(self, prim: Usd.Prim, apis: Sequence[str], above: _Inherited) -> None:
        collides = above.collides
        if "PhysicsCollisionAPI" in apis:
            collides = bool(value(prim, "physics:collisionEnabled", True))
        visible = above.visible and above.purpose in _DRAWN
        if not collides and not visible:
            return
        if prim.GetTypeName() == "Plane" and not collides:
            remedy = "use a Cube or a Mesh"
            self._notes.record(prim, "a plane without collision is not supported", "omitted from pictures", remedy)
            return
        owner = above.owner or BodyPrim(prim, "static")
        owner = self.census.owners.setdefault(str(owner.prim.GetPath()), owner)
        owner.pieces.append(GeomPrim(prim, collides, visible))


def _motion(prim: Usd.Prim) -> Motion:
    if not value(prim, "physics:rigidBodyEnabled", True):
        return "static"
    if value(prim, "physics:startsAsleep", False):
        refuse(prim, "bodies that start asleep are not supported", "author physics:startsAsleep = false")
    return "kinematic" if value(prim, "physics:kinematicEnabled", False) else "dynamic"


def _is_component(prim: Usd.Prim) -> bool:
    kind = Usd.ModelAPI(prim).GetKind()
    return bool(kind) and bool(Kind.Registry.IsA(kind, Kind.Tokens.component))
