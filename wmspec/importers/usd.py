"""USD by UsdGeom and UsdPhysics: rigid bodies, shapes, masses, joints. What bears on them and is not known is refused.

Geometry outside any rigid body is the base, which never moves; but a file without any physics is one thing, which can
move and all of which is touched. Lights, cameras and physics scenes are the spec's
business and left out, and so are the attributes of single engines.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from pxr import Usd, UsdPhysics

from wmspec.importers import usd_bodies, usd_joints, usd_pieces
from wmspec.importers.model import MOST_LINKS, MOST_SHAPES, Asset, Faults, Joint, Link
from wmspec.importers.tree import WORLD
from wmspec.importers.usd_bodies import Body
from wmspec.importers.usd_open import opened
from wmspec.importers.usd_prims import Prims

#: The most prims.
MOST_PRIMS = 20_000
_GEOMETRIES = ("Cube", "Sphere", "Cylinder", "Capsule", "Cone", "Mesh")
_JOINTS = ("PhysicsRevoluteJoint", "PhysicsPrismaticJoint", "PhysicsSphericalJoint", "PhysicsFixedJoint")
_PASSED = ("", "Xform", "Scope", "GeomSubset")
_LIGHTS = ("DistantLight", "DomeLight", "SphereLight", "RectLight", "DiskLight", "CylinderLight")
_LEFT_OUT = ("Material", "PhysicsScene", "Camera", *_LIGHTS)
_APIS = (
    "PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "PhysicsMassAPI", "PhysicsArticulationRootAPI", "PhysicsMaterialAPI",
    "PhysicsDriveAPI", "PhysicsMeshCollisionAPI",
)  # fmt: skip

#: What a stage without any physics has on none of its prims.
_PHYSICAL = (UsdPhysics.RigidBodyAPI, UsdPhysics.CollisionAPI)


def usd(path: Path, folder: Path, shown: str, faults: Faults) -> Asset:
    """The asset in a USD file, all of whose layers are below a folder. Raises Broken if it cannot be read."""
    with opened(path, folder, shown, faults) as prims:
        return _Usd(prims).asset()


class _Usd:
    def __init__(self, prims: Prims) -> None:
        self.prims = prims
        self.faults = prims.faults
        self.bodies: dict[str, Body] = {}
        self.base = Body("base", prims.shown, np.eye(4))
        self.joints: list[Usd.Prim] = []
        self.bare = False

    def asset(self) -> Asset:
        """The base, the rigid bodies and the joints between them; or all of it as one, without any physics."""
        every = list(self._walk())
        self.bare = not any(prim.HasAPI(api) for prim in every for api in _PHYSICAL)
        for prim in every:
            self._take(prim)
        self._sized()
        links = self._links()
        if self.bare:
            return Asset(links, {})
        base = links.pop(self.base.name)
        root = base.name if base.shapes else WORLD
        frames = {body.name: body.frame for body in self.bodies.values()}
        ends = {path: body.name for path, body in self.bodies.items()}
        joints: dict[str, Joint] = {}
        for joint in usd_joints.joints(self.prims, self.joints, ends, frames, root):
            if joint.name in joints:
                self.faults.add(joint.where, "another joint has this name", "rename one of them")
            joints.setdefault(joint.name, joint)
        world = Link(WORLD, self.prims.shown)
        if base.shapes:  # it stands on the world
            joints[""] = usd_joints.welded(WORLD, root, base.where)
            links = {WORLD: world, root: base, **links}
        elif any(joint.parent == WORLD for joint in joints.values()):
            links[WORLD] = world
        return Asset(links, joints)

    def _sized(self) -> None:
        """Complain about nothing, and about too much."""
        if not (self.bodies or self.base.shapes or self.faults.found):
            raise self.faults.stop(self.prims.shown, "has no geometry", "is this the right file?")
        bodies = [self.base, *self.bodies.values()]
        if len(bodies) > MOST_LINKS or sum(len(body.shapes) for body in bodies) > MOST_SHAPES:
            what = f"has more than {MOST_LINKS} rigid bodies or {MOST_SHAPES} shapes"
            raise self.faults.stop(self.prims.shown, what, "make it simpler")

    def _links(self) -> dict[str, Link]:
        """The base, whose name nothing else has, and the rigid bodies."""
        taken = {body.name for body in self.bodies.values()}
        if WORLD in taken:
            raise self.faults.stop(self.prims.shown, "a rigid body is called `world`", "rename it")
        self.base.name = next(name for name in ("base", "stand", "ground", "base_of_all") if name not in taken)
        links: dict[str, Link] = {}
        for body in (self.base, *self.bodies.values()):
            if body.name in links:
                self.faults.add(body.where, f"another rigid body is called `{body.name}` too", "rename one of them")
            links[body.name] = usd_bodies.link(self.prims, body)
        return links

    def _walk(self) -> Iterator[Usd.Prim]:
        """All prims but those below what is left out."""
        prims = iter(Usd.PrimRange(self.prims.stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()))
        for count, prim in enumerate(prims):
            if count > MOST_PRIMS:
                raise self.faults.stop(self.prims.shown, f"has more than {MOST_PRIMS:,} prims", "make it simpler")
            if prim.GetTypeName() in _LEFT_OUT:
                prims.PruneChildren()
            elif not prim.IsPseudoRoot():
                yield prim

    def _take(self, prim: Usd.Prim) -> None:
        kind, where = str(prim.GetTypeName()), self.prims.where(prim)
        for api in prim.GetAppliedSchemas():
            if api.startswith("Physics") and api.partition(":")[0] not in _APIS:
                self.faults.add(where, f"`{api}` is not supported", "remove it")
        if kind in _JOINTS:
            self.joints.append(prim)
            return
        if kind not in (*_PASSED, *_GEOMETRIES):
            known = ", ".join((*_GEOMETRIES, *_JOINTS))
            self.faults.add(where, f"prims of type `{kind}` are not supported in an asset", f"it can have: {known}")
            return
        if prim.HasAPI(UsdPhysics.RigidBodyAPI) and self.prims.value(prim, "physics:rigidBodyEnabled", True):
            self._still(prim)
            frame, _ = self.prims.rigid(prim)
            self.bodies[str(prim.GetPath())] = Body(prim.GetName(), where, frame, prim)
        if kind in _GEOMETRIES:
            body = next(
                (self.bodies[p] for p in map(str, prim.GetPath().GetAncestorsRange()) if p in self.bodies), None
            )
            self._piece(prim, body or self.base)

    def _still(self, prim: Usd.Prim) -> None:
        """Complain about bodies that do not simply begin at rest."""
        for name, remedy in (
            ("velocity", "let the spec `launch` it"),
            ("angularVelocity", "let the spec `launch` it"),
            ("kinematicEnabled", "let the spec move it"),
            ("startsAsleep", "remove it"),
        ):
            found = self.prims.value(prim, f"physics:{name}", 0)
            if np.any(np.array(found, float)):
                self.faults.add(self.prims.where(prim), f"physics:{name} is not supported", remedy)

    def _piece(self, prim: Usd.Prim, body: Body) -> None:
        if self.bare:
            body.shapes += usd_pieces.bare(self.prims, prim, body.frame)
            return
        solid = usd_pieces.is_solid(self.prims, prim)
        body.shapes += usd_pieces.shapes(self.prims, prim, body.frame, solid=solid, still=body is self.base)
        if solid:
            body.colliders.append(prim)
