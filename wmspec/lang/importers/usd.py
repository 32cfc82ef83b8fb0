"""Imports USD: rigid bodies become links, all other geometry the base; joints and collision filters are kept.

Geometry outside rigid bodies never moves. A file without physics is one movable object with collision everywhere.
Cameras, lights, physics scenes and episodes are ignored: the spec sets them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
from pxr import Usd

from wmspec.core.diagnostics import Diagnostic, Report, StageError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import is_within
from wmspec.lang.check.tables.vocabulary import COLLISIONS, FILES
from wmspec.lang.importers.model import (
    MAX_LINKS,
    MAX_SHAPES,
    OVERRIDING_PROPERTIES,
    Appearance,
    Asset,
    Conditional,
    Faults,
    Link,
    MeshFile,
    Shape,
    conditional,
)
from wmspec.lang.importers.usd_file import REST, add_problems, add_substitutions, check_mesh_size, stage_of
from wmspec.lang.importers.usd_tree import Stage
from wmspec.sim.scene.model import Body, Motion
from wmspec.sim.shapes import Mesh
from wmspec.sim.usd import actuators, joints, meshes
from wmspec.sim.usd.bodies import body
from wmspec.sim.usd.colliders import collision_approximation
from wmspec.sim.usd.filters import filtered_pairs
from wmspec.sim.usd.frames import StageFrame, split_transform
from wmspec.sim.usd.geoms import MaterialTable
from wmspec.sim.usd.ignored_attributes import warn_ignored_attributes
from wmspec.sim.usd.layer_metrics import warn_layer_metrics, warn_missing_unit
from wmspec.sim.usd.masses import body_inertia
from wmspec.sim.usd.prims import Names, applied_schemas, refuse
from wmspec.sim.usd.shapes import PlacedShape, placed_shape
from wmspec.sim.usd.stage_index import BodyPrim, GeomPrim, StageWalk
from wmspec.sim.usd.substitutions import Substitutions
from wmspec.sim.usd.unsupported import TYPES

#: Prim types that the spec sets, not the asset.
_IGNORED_TYPES = frozenset(
    {"PhysicsScene", "Camera", "DistantLight", "DomeLight", "WmsEpisode", "WmsAction", "WmsObservation"}
    | {kind for kind in TYPES if "Light" in kind}
)
_WORDS = {way: word for word, way in COLLISIONS.items()}


def usd(path: Path, folder: Path, shown: str, faults: Faults) -> Asset:
    """Return the asset of a USD file whose layers are all below a folder. Raises Broken if it cannot be read."""
    with stage_of(path, folder, shown, faults) as stage:
        return _Usd(stage, folder, shown, faults).asset()


class _Usd:
    """Reads one stage; errors are collected and added to the faults at the end."""

    def __init__(self, stage: Usd.Stage, folder: Path, shown: str, faults: Faults) -> None:
        self.stage, self.folder, self.shown, self.faults = stage, folder.resolve(), shown, faults
        self.problems = Report(StageError)
        self.notes = Substitutions(strict=False)
        self.world = StageFrame(stage, self.problems)
        self.census = StageWalk(stage, self.problems, _IGNORED_TYPES, self.notes).census
        self.owners = tuple(self.census.owners.values())
        self.materials = MaterialTable((piece for owner in self.owners for piece in owner.pieces), pictured=True)

    def asset(self) -> Asset:
        """Return the base, the rigid bodies and their joints, or one link for a stage without physics."""
        self._check_size()
        warn_missing_unit(self.stage, self.notes)
        if not any(_physical(owner) for owner in self.owners):
            whole = Link("base", FilePlace(self.shown), tuple(self._shapes_without_physics()))
            self._report()
            return Asset({whole.name: whole}, {})
        bodies, shapes = self._bodies()
        chained = joints.joints(self.census.joints, bodies, self.world, self.problems, self.notes)
        acting = [prim for kind in actuators.TYPES for prim in self.census.of(kind)]
        held = actuators.with_actuators(acting, chained.joints, self.problems, self.notes)
        apart: tuple[tuple[str, str], ...] = ()
        with self.problems.collect_errors():
            groups = self.census.of("PhysicsCollisionGroup")
            owners = self.census.owners
            apart = filtered_pairs(self.stage, self.census.filters, groups, owners, bodies, held, self.notes)
        with self.problems.collect_errors():
            warn_ignored_attributes(self.stage, self.problems, self.notes)
            warn_layer_metrics(self.stage, self.notes)
        self._report()
        between = {link.name: replace(link, path=link.name) for link in chained.between}
        stage = Stage(bodies | between, shapes | dict.fromkeys(between, ()), apart, self.shown)
        return Asset(stage.links, {}) if self.faults.diagnostics else stage.asset(tuple(held.values()), self.faults)

    def _report(self) -> None:
        """Add the errors and substitutions of the reading to the faults."""
        add_problems(self.problems.diagnostics, self.shown, self.faults, self.folder)
        add_substitutions(self.notes, self.shown, self.faults)

    def _check_size(self) -> None:
        """Report an empty and a too large stage."""
        if not (self.owners or self.problems.failed):
            raise self.faults.stop(FilePlace(self.shown), "has no geometry", "is this the right file?")
        if len(self.owners) > MAX_LINKS + MAX_SHAPES or sum(len(o.pieces) for o in self.owners) > MAX_SHAPES:
            what = f"has more than {MAX_LINKS} rigid bodies or {MAX_SHAPES} shapes"
            raise self.faults.stop(FilePlace(self.shown), what, "make it simpler")

    # ------------------------------------------------------------ bodies

    def _bodies(self) -> tuple[dict[str, Body], dict[str, tuple[Shape, ...]]]:
        """Return the bodies without geometry, and their geometry as shapes in their frames, both by prim path."""
        names = Names()
        bodies: dict[str, Body] = {}
        shapes: dict[str, tuple[Shape, ...]] = {}
        for owner in self.owners:
            path = str(owner.prim.GetPath())
            name = names.give(owner.prim.GetName(), path)
            with self.problems.collect_errors():
                bodies[path], shapes[path] = self._body(owner, name)
        return bodies, shapes

    def _body(self, owner: BodyPrim, name: str) -> tuple[Body, tuple[Shape, ...]]:
        place = split_transform(self.world.matrix(owner.prim), owner.prim)
        back, shapes, colliders = place.rigid.GetInverse(), list[Shape](), list[tuple[PlacedShape, float]]()
        problems = Report(StageError)
        for piece in owner.pieces:
            with problems.collect_errors():
                check_mesh_size(piece.prim)
                inner = split_transform(self.world.matrix(piece.prim) * back, piece.prim)
                here = placed_shape(piece.prim, inner)
                shapes += self._shapes(piece, here, owner.motion)
                if piece.collides:
                    colliders.append((here, self.materials.density(piece.prim)))
        problems.stop_if_failed()
        mass = None
        if owner.motion == "dynamic":
            try:
                mass = body_inertia(owner.prim, place, colliders, self.world, notes=self.notes)
            except StageError:
                if not any(shape.conditional for shape in shapes):
                    raise
        return body(owner, name, place.pose, (), mass, self.world), tuple(shapes)

    def _shapes_without_physics(self) -> Iterator[Shape]:
        """Yield all drawn geometry of a stage without physics: all of it collides except flat sheets."""
        for piece in (piece for owner in self.owners for piece in owner.pieces):
            with self.problems.collect_errors():
                check_mesh_size(piece.prim)
                here = placed_shape(piece.prim, split_transform(self.world.matrix(piece.prim), piece.prim))
                touches = not (isinstance(here.shape, Mesh) and meshes.is_flat(here.shape))
                yield from self._shapes(GeomPrim(piece.prim, touches, visible=True), here, None)

    # ------------------------------------------------------------ shapes

    def _shapes(self, piece: GeomPrim, here: PlacedShape, motion: Motion | None) -> Iterator[Shape]:
        """Yield a geometry, split into parts of different appearance, plus the whole for collisions.

        Without a `motion` the stage has no physics: meshes collide as hulls, the language's default.
        """
        prim, rubs = piece.prim, None
        if piece.collides and motion is not None:
            self.materials.alike(prim)
            rubs = self._rubs(prim)
        if not isinstance(here.shape, Mesh):
            look = self._look(prim) if piece.visible else Appearance()
            yield Shape(here.shape, here.pose, look, piece.collides, piece.visible, rubs)
            return
        way, why = self._touched(prim, here.shape, motion) if piece.collides and motion else ("hull", ())
        file = f"{self.shown}#{prim.GetPath()}"
        corners = tuple(product(*here.shape.bounds(np.eye(3)).T.tolist()))
        parts = meshes.parts(prim) if piece.visible else []
        for part, _ in parts:
            name = f"{file}{REST}" if part == prim else f"{self.shown}#{part.GetPath()}"
            yield Shape(MeshFile(name, corners=corners), here.pose, self._look(part), solid=False)
        if piece.collides or not parts:
            drawn = piece.visible and not parts
            look = self._look(prim) if drawn else Appearance()
            form = MeshFile(file, collision=way, corners=corners)
            yield Shape(form, here.pose, look, piece.collides, drawn, rubs, why)

    def _rubs(self, prim: Usd.Prim) -> tuple[float, float]:
        """Return friction and restitution of a collider."""
        friction = self.materials.friction(prim)
        if friction.static != friction.dynamic:
            reason = f"its static friction {friction.static:g} differs from its dynamic friction {friction.dynamic:g}"
            self.notes.record(prim, reason, "that of motion is used", "make them equal, or author one")
        return friction.dynamic, friction.restitution

    def _touched(self, prim: Usd.Prim, mesh: Mesh, motion: Motion) -> tuple[str, tuple[Conditional, ...]]:
        """Return the collision mode of a mesh as a word of the language, and why the file's mode is unsupported."""
        try:
            return _WORDS[collision_approximation(prim, mesh, motion)], ()
        except StageError as error:
            if meshes.is_flat(mesh):
                raise
            way = "pieces" if motion == "dynamic" else "hull"
            taken = {"pieces": "its convex pieces", "hull": "its convex hull"}[way]
            return way, conditional(self._approximations(error, taken), ("collision",))

    def _look(self, prim: Usd.Prim) -> Appearance:
        """Return the appearance of a geometry or subset, and its unsupported features."""
        try:
            surface = self.materials.surface(prim)
            if surface is None:
                return Appearance()
            image = self._image(prim, surface.texture) if surface.texture else ""
        except StageError as error:
            said = self._approximations(error, "a plain colour is drawn")
            return Appearance(conditional=conditional(said, OVERRIDING_PROPERTIES))
        color = None if image and surface.color == (1, 1, 1) else surface.color
        return Appearance(color, image, surface.repeats, surface.roughness, surface.metallic)

    def _image(self, prim: Usd.Prim, texture: str) -> str:
        """Return the path of an image relative to the spec's folder. Raises StageError if it is missing or invalid."""
        path = Path(texture)
        if not is_within(self.folder, path):
            what = f"there is no picture `{path.name[:80]}` below the spec's folder"
            refuse(prim, what, "put it there, outside any package")
        if path.suffix.lower() not in FILES["image"]:
            refuse(prim, f"`{path.name[:80]}` is no picture that can be read", f"make it {', '.join(FILES['image'])}")
        return path.resolve().relative_to(self.folder).as_posix()

    def _approximations(self, error: StageError, taken: str) -> list[Diagnostic]:
        """Return warnings that `taken` replaces the subject of an error."""
        faults = Faults()
        add_problems(error.diagnostics, self.shown, faults, self.folder)
        for fault in faults.diagnostics:
            assert isinstance(fault.place, FilePlace)
            faults.approximate(fault.place, fault.message, taken, fault.help)
        return faults.warnings


def _physical(owner: BodyPrim) -> bool:
    """Whether a body or any descendant has physics attributes."""
    return "PhysicsRigidBodyAPI" in applied_schemas(owner.prim) or any(
        "PhysicsCollisionAPI" in applied_schemas(piece.prim) for piece in owner.pieces
    )
