"""USD by UsdGeom and UsdPhysics: rigid bodies, shapes, masses, joints. What bears on them and is not known is refused.

Geometry outside any rigid body is the base, which never moves. Lights, cameras and physics scenes are the spec's
business and left out, and so are the attributes of single engines.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from pxr import Usd, UsdGeom, UsdPhysics, UsdUtils

from wmspec.check.assets import usd_joints, usd_looks, usd_shapes
from wmspec.check.assets.model import MOST_LINKS, MOST_SHAPES, Array, Asset, Broken, Faults, Joint, Link, Mass, Shape
from wmspec.check.assets.tree import WORLD
from wmspec.check.assets.usd_prims import Prims

#: The largest file (bytes) and the most prims.
MOST_BYTES, MOST_PRIMS = 20_000_000, 20_000
_GEOMETRIES = ("Cube", "Sphere", "Cylinder", "Capsule", "Cone")
_JOINTS = ("PhysicsRevoluteJoint", "PhysicsPrismaticJoint", "PhysicsSphericalJoint", "PhysicsFixedJoint")
_PASSED = ("", "Xform", "Scope")
_LEFT_OUT = ("Material", "PhysicsScene", "Camera", "DistantLight", "DomeLight", "SphereLight", "RectLight", "DiskLight")
_APIS = (
    "PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "PhysicsMassAPI", "PhysicsArticulationRootAPI", "PhysicsMaterialAPI",
    "PhysicsDriveAPI",
)  # fmt: skip


@dataclass
class _Body:
    """A rigid body, or the base (without a prim), and what was found in it."""

    name: str
    where: str
    frame: Array
    prim: Usd.Prim | None = None
    shapes: list[Shape] = field(default_factory=list)
    colliders: list[Usd.Prim] = field(default_factory=list)


def usd(path: Path, folder: Path, shown: str, faults: Faults) -> Asset:
    """The asset in a USD file, all of whose layers are below a folder. Raises Broken if it cannot be read."""
    if path.stat().st_size > MOST_BYTES:
        raise faults.stop(shown, f"is larger than {MOST_BYTES // 1_000_000} MB", "is this the right file?")
    quiet = UsdUtils.CoalescingDiagnosticDelegate()  # what USD would print is told by us
    try:
        stage = Usd.Stage.Open(str(path))
        _whole(stage, folder, shown, faults)
        return _Usd(Prims(stage, shown, faults)).asset()
    except Broken:
        raise
    except Exception as error:  # noqa: BLE001  what others wrote may be of any type
        what = _first(error).replace(str(path.resolve()), path.name)
        raise faults.stop(shown, f"cannot be read: {what}", "mend it, or export it again") from None
    finally:
        del quiet


def _whole(stage: Usd.Stage, folder: Path, shown: str, faults: Faults) -> None:
    """Complain about what a stage is made of and is missing, or elsewhere."""
    for wrong in stage.GetCompositionErrors()[:1]:
        what = " ".join(str(wrong).split()).replace(str(folder.resolve()) + "/", "")
        raise faults.stop(shown, f"cannot be composed: {what[:160]}", "mend its references")
    for layer in stage.GetUsedLayers():
        if not (layer.anonymous or Path(layer.realPath).resolve().is_relative_to(folder.resolve())):
            what = f"uses `{Path(layer.identifier).name}`, which is not below the spec's folder"
            raise faults.stop(shown, what, "put it beside the asset")


def _first(error: Exception) -> str:
    """The first thing that pxr complains about, without where in its own source."""
    said = str(error).partition(" : '")[2].partition("'\n")[0] or str(error) or type(error).__name__
    return " ".join(said.replace("</", "<").split())[:120]


class _Usd:
    def __init__(self, prims: Prims) -> None:
        self.prims = prims
        self.faults = prims.faults
        self.bodies: dict[str, _Body] = {}
        self.base = _Body("base", prims.shown, np.eye(4))
        self.joints: list[Usd.Prim] = []

    def asset(self) -> Asset:
        """The base, the rigid bodies and the joints between them."""
        for prim in self._walk():
            self._take(prim)
        self._sized()
        links = self._links()
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
        if not self.bodies:
            help = "apply PhysicsRigidBodyAPI to what can move"
            raise self.faults.stop(self.prims.shown, "has no rigid bodies", help)
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
            links[body.name] = self._link(body)
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
            self.bodies[str(prim.GetPath())] = _Body(prim.GetName(), where, frame, prim)
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

    def _piece(self, prim: Usd.Prim, body: _Body) -> None:
        solid = prim.HasAPI(UsdPhysics.CollisionAPI) and bool(self.prims.value(prim, "physics:collisionEnabled", True))
        drawn = UsdGeom.Imageable(prim).ComputeVisibility() != "invisible"
        drawn = drawn and UsdGeom.Imageable(prim).ComputePurpose() in ("default", "render")
        shape = usd_shapes.shape(self.prims, prim, body.frame) if solid or drawn else None
        if shape is None:
            return
        color = usd_looks.color(self.prims, prim) if drawn else None
        body.shapes.append(replace(shape, solid=solid, drawn=drawn, color=color))
        if solid:
            body.colliders.append(prim)

    # ------------------------------------------------------------ masses

    def _link(self, body: _Body) -> Link:
        said = usd_looks.rubs(self.prims, body.colliders)
        if body.prim is None:
            return Link(body.name, body.where, tuple(body.shapes), None, said)
        mass = self._mass(body)
        if mass is None:
            said = {"density": self._density(body), **said}
        return Link(body.name, body.where, tuple(body.shapes), mass, said)

    def _mass(self, body: _Body) -> Mass | None:
        """The mass of a body, or of its only collider; None if it follows from a density."""
        assert body.prim is not None
        sources = [p for p in (body.prim, *body.colliders) if p.HasAPI(UsdPhysics.MassAPI)]
        massive = [p for p in sources if self.prims.number(p, "physics:mass", 0.0) > 0]
        if body.prim in massive:
            prim = body.prim
        elif massive and len(body.colliders) > 1:
            what = "the masses of several colliders are not supported"
            self.faults.add(body.where, what, "author physics:mass on the rigid body instead")
            return None
        elif not massive:
            for p in sources:
                if np.any(np.array(self.prims.value(p, "physics:diagonalInertia", (0, 0, 0)), float)):
                    what = "moments of inertia without a mass are not supported"
                    self.faults.add(self.prims.where(p), what, "author physics:mass too")
            return None
        else:
            prim = massive[0]
        return self._weighed(prim, body)

    def _weighed(self, prim: Usd.Prim, body: _Body) -> Mass:
        """What the PhysicsMassAPI of a body or its collider says, in the body's frame."""
        kilograms, meters = self.prims.kilograms, self.prims.meters
        mass = self.prims.number(prim, "physics:mass", 0.0) * kilograms
        at = np.array(self.prims.value(prim, "physics:centerOfMass", (np.inf,) * 3), float)
        moments = np.array(self.prims.value(prim, "physics:diagonalInertia", (0, 0, 0)), float)
        whole = self.prims.world(prim)
        seen = np.linalg.inv(body.frame)
        centre = (seen @ whole @ (*at, 1.0))[:3] if np.isfinite(at).all() else None
        if not moments.any():
            if centre is None and prim is not body.prim:
                return Mass(mass)
            return Mass(mass, centre)
        turn = seen[:3, :3] @ self.prims.rigid(prim)[0][:3, :3]
        axes = self.prims.value(prim, "physics:principalAxes", None)
        if axes is not None and axes.GetLength() > 0:
            turn = turn @ self.prims.turn(axes)
        tensor = turn @ np.diag(moments * kilograms * meters**2) @ turn.T
        return Mass(mass, centre, tensor)

    def _density(self, body: _Body) -> float:
        """The density of a body without a mass: its own, or that of all its colliders, or that of water."""
        assert body.prim is not None
        own = self.prims.number(body.prim, "physics:density", 0.0)
        each = {
            self.prims.number(p, "physics:density", 0.0) or usd_looks.density(self.prims, p) for p in body.colliders
        }
        if not own and len(each) > 1:
            self.faults.add(body.where, "its colliders have several densities", "author physics:density on the body")
        found = own or max(each, default=0.0)
        return found * self.prims.kilograms / self.prims.meters**3 if found else 1000.0
