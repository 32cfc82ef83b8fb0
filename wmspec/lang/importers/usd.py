"""USD as the reader of stages reads it: its rigid bodies as links, all else as the base, joints, what passes what.

Geometry outside any rigid body never moves; but a file without any physics is one thing, which can move and all of
which is touched. Cameras, lights, physics scenes and episodes are the spec's business and left out.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from pxr import Usd

from wmspec.core.diagnostics import Diagnostic, Report, StageError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import inside
from wmspec.lang.check.tables.vocabulary import COLLISIONS, FILES
from wmspec.lang.importers.model import (
    LOOKS,
    MOST_LINKS,
    MOST_SHAPES,
    Asset,
    Conditional,
    Faults,
    Link,
    Look,
    MeshFile,
    Shape,
    conditional,
)
from wmspec.lang.importers.usd_file import REST, bounded, note, stage_of
from wmspec.lang.importers.usd_tree import Stage
from wmspec.sim.scene.model import Body, Motion
from wmspec.sim.shapes import Mesh
from wmspec.sim.usd import joints, meshes
from wmspec.sim.usd.bodies import body
from wmspec.sim.usd.colliders import touched
from wmspec.sim.usd.filters import filtered
from wmspec.sim.usd.frames import World, split
from wmspec.sim.usd.geoms import Materials
from wmspec.sim.usd.masses import body_inertia
from wmspec.sim.usd.prims import Names, applied, refuse
from wmspec.sim.usd.shapes import Placed, placed
from wmspec.sim.usd.stage_index import Owner, Piece, Walk
from wmspec.sim.usd.unsupported import TYPES

#: What is the spec's business, and no part of an asset.
_ASIDE = frozenset(
    {"PhysicsScene", "Camera", "DistantLight", "DomeLight", "WmsEpisode", "WmsAction", "WmsObservation"}
    | {kind for kind in TYPES if "Light" in kind}
)
_WORDS = {way: word for word, way in COLLISIONS.items()}


def usd(path: Path, folder: Path, shown: str, faults: Faults) -> Asset:
    """The asset in a USD file, all of whose layers are below a folder. Raises Broken if it cannot be read."""
    with stage_of(path, folder, shown, faults) as stage:
        return _Usd(stage, folder, shown, faults).asset()


class _Usd:
    """Reads one stage; what is wrong with it is noted, and goes to the faults in the end."""

    def __init__(self, stage: Usd.Stage, folder: Path, shown: str, faults: Faults) -> None:
        self.stage, self.folder, self.shown, self.faults = stage, folder.resolve(), shown, faults
        self.problems = Report(StageError)
        self.world = World(stage, self.problems)
        self.census = Walk(stage, self.problems, _ASIDE).census
        self.owners = tuple(self.census.owners.values())
        self.materials = Materials((piece for owner in self.owners for piece in owner.pieces), pictured=True)

    def asset(self) -> Asset:
        """The base, the rigid bodies and the joints between them; or all of it as one, without any physics."""
        self._sized()
        if not any(_physical(owner) for owner in self.owners):
            whole = Link("base", FilePlace(self.shown), tuple(self._bare()))
            note(self.problems.diagnostics, self.shown, self.faults, self.folder)
            return Asset({whole.name: whole}, {})
        bodies, shapes = self._bodies()
        held = joints.joints(self.census.joints, bodies, self.world, self.problems).joints
        apart: tuple[tuple[str, str], ...] = ()
        with self.problems.gathered():
            groups = self.census.of("PhysicsCollisionGroup")
            apart = filtered(self.stage, self.census.filters, groups, self.census.owners, bodies, held)
        note(self.problems.diagnostics, self.shown, self.faults, self.folder)
        stage = Stage(bodies, shapes, apart, self.shown)
        return Asset(stage.links, {}) if self.faults.diagnostics else stage.asset(tuple(held.values()), self.faults)

    def _sized(self) -> None:
        """Complain about nothing, and about too much."""
        if not (self.owners or self.problems.failed):
            raise self.faults.stop(FilePlace(self.shown), "has no geometry", "is this the right file?")
        if len(self.owners) > MOST_LINKS + MOST_SHAPES or sum(len(o.pieces) for o in self.owners) > MOST_SHAPES:
            what = f"has more than {MOST_LINKS} rigid bodies or {MOST_SHAPES} shapes"
            raise self.faults.stop(FilePlace(self.shown), what, "make it simpler")

    # ------------------------------------------------------------ bodies

    def _bodies(self) -> tuple[dict[str, Body], dict[str, tuple[Shape, ...]]]:
        """The bodies without their geometries, and these as shapes in their frames, both by the bodies' paths."""
        names = Names()
        bodies: dict[str, Body] = {}
        shapes: dict[str, tuple[Shape, ...]] = {}
        for owner in self.owners:
            path = str(owner.prim.GetPath())
            name = names.give(owner.prim.GetName(), path)
            with self.problems.gathered():
                bodies[path], shapes[path] = self._body(owner, name)
        return bodies, shapes

    def _body(self, owner: Owner, name: str) -> tuple[Body, tuple[Shape, ...]]:
        place = split(self.world.matrix(owner.prim), owner.prim)
        back, shapes, colliders = place.rigid.GetInverse(), list[Shape](), list[tuple[Placed, float]]()
        problems = Report(StageError)
        for piece in owner.pieces:
            with problems.gathered():
                bounded(piece.prim)
                here = placed(piece.prim, split(self.world.matrix(piece.prim) * back, piece.prim))
                shapes += self._shapes(piece, here, owner.motion)
                if piece.collides:
                    colliders.append((here, self.materials.density(piece.prim)))
        problems.stop_if_failed()
        mass = None
        if owner.motion == "dynamic":
            try:
                mass = body_inertia(owner.prim, place, colliders, self.world)
            except StageError:
                if not any(shape.conditional for shape in shapes):
                    raise
        return body(owner, name, place.pose, (), mass, self.world), tuple(shapes)

    def _bare(self) -> Iterator[Shape]:
        """All that is drawn where nothing says what is touched: all of it is, but for sheets."""
        for piece in (piece for owner in self.owners for piece in owner.pieces):
            with self.problems.gathered():
                bounded(piece.prim)
                here = placed(piece.prim, split(self.world.matrix(piece.prim), piece.prim))
                touches = not (isinstance(here.shape, Mesh) and meshes.is_flat(here.shape))
                yield from self._shapes(Piece(piece.prim, touches, visible=True), here, None)

    # ------------------------------------------------------------ shapes

    def _shapes(self, piece: Piece, here: Placed, motion: Motion | None) -> Iterator[Shape]:
        """A geometry; if parts of a mesh look different each of these, and the whole if it can be touched.

        Without a `motion` nothing says how meshes are touched and what rubs: by their hulls, as the language says.
        """
        prim, rubs = piece.prim, None
        if piece.collides and motion is not None:
            self.materials.alike(prim)
            rubs = self._rubs(prim)
        if not isinstance(here.shape, Mesh):
            look = self._look(prim) if piece.visible else Look()
            yield Shape(here.shape, here.pose, look, piece.collides, piece.visible, rubs)
            return
        way, why = self._touched(prim, here.shape, motion) if piece.collides and motion else ("hull", ())
        file = f"{self.shown}#{prim.GetPath()}"
        parts = meshes.parts(prim) if piece.visible else []
        for part, _ in parts:
            name = f"{file}{REST}" if part == prim else f"{self.shown}#{part.GetPath()}"
            yield Shape(MeshFile(name), here.pose, self._look(part), solid=False)
        if piece.collides or not parts:
            drawn = piece.visible and not parts
            look = self._look(prim) if drawn else Look()
            yield Shape(MeshFile(file, collision=way), here.pose, look, piece.collides, drawn, rubs, why)

    def _rubs(self, prim: Usd.Prim) -> tuple[float, float]:
        """Friction and restitution of a collider. Raises StageError if it rubs in two ways."""
        friction = self.materials.friction(prim)
        if friction.static != friction.dynamic:
            reason = f"its static friction {friction.static:g} differs from its dynamic friction {friction.dynamic:g}"
            refuse(prim, reason, "make them equal, or author one")
        return friction.dynamic, friction.restitution

    def _touched(self, prim: Usd.Prim, mesh: Mesh, motion: Motion) -> tuple[str, tuple[Conditional, ...]]:
        """How a mesh is touched, as a word of the language, and why it cannot be as its file says."""
        try:
            return _WORDS[touched(prim, mesh, motion)], ()
        except StageError as error:
            if meshes.is_flat(mesh):
                raise
            return "hull", conditional(self._told(error), ("collision",))

    def _look(self, prim: Usd.Prim) -> Look:
        """How a geometry or subset looks, and what of it cannot be honoured."""
        try:
            surface = self.materials.surface(prim)
            if surface is None:
                return Look()
            image = self._picture(prim, surface.texture) if surface.texture else ""
        except StageError as error:
            return Look(conditional=conditional(self._told(error), LOOKS))
        color = None if image and surface.color == (1, 1, 1) else surface.color
        return Look(color, image, surface.repeats, surface.roughness, surface.metallic)

    def _picture(self, prim: Usd.Prim, texture: str) -> str:
        """The file of a picture, seen from the spec's folder. Raises StageError if it is not there, or no picture."""
        path = Path(texture)
        if not inside(self.folder, path):
            what = f"there is no picture `{path.name[:80]}` below the spec's folder"
            refuse(prim, what, "put it there, outside any package")
        if path.suffix.lower() not in FILES["image"]:
            refuse(prim, f"`{path.name[:80]}` is no picture that can be read", f"make it {', '.join(FILES['image'])}")
        return path.resolve().relative_to(self.folder).as_posix()

    def _told(self, error: StageError) -> list[Diagnostic]:
        faults = Faults()
        note(error.diagnostics, self.shown, faults, self.folder)
        return faults.diagnostics


def _physical(owner: Owner) -> bool:
    """Whether physics is said of a body or of anything in it."""
    return "PhysicsRigidBodyAPI" in applied(owner.prim) or any(
        "PhysicsCollisionAPI" in applied(piece.prim) for piece in owner.pieces
    )
