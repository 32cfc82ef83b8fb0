"""Converts bodies and joints of a stage to a kinematic tree.

Static geometry is the base. The parent of each joint is the link closer to the base.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from wmspec.core.diagnostics import StageError
from wmspec.core.places import FilePlace, PrimPlace
from wmspec.lang.check.tables.vocabulary import PROPERTIES
from wmspec.lang.importers.blocks import to_identifier
from wmspec.lang.importers.massless import placeholder
from wmspec.lang.importers.model import MAX_LINKS, Asset, Faults, Joint, Link, Shape
from wmspec.lang.importers.tree import WORLD
from wmspec.lang.importers.turns import X
from wmspec.lang.importers.usd_file import add_problems
from wmspec.sim.scene import model
from wmspec.sim.scene.joints.articulations import joint_coordinate, relative_frame
from wmspec.sim.scene.model import Body, Pose
from wmspec.sim.scene.model.transform import compose, identity, inverse, rotate
from wmspec.sim.usd.prims import Names

Pair = tuple[str, str]

#: Default density of UsdPhysics (kg/m³).
_DEFAULT_DENSITY = 1000.0
_OVER = Pose(np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]))


class Stage:
    """Links of a stage: `shapes` are in the frames of the bodies, both by path; pairs in `apart` do not collide."""

    def __init__(
        self, bodies: Mapping[str, Body], shapes: Mapping[str, tuple[Shape, ...]], apart: Sequence[Pair], shown: str
    ) -> None:
        self._shown, self._file = shown, FilePlace(shown)
        self._bodies = {body.name: body for body in bodies.values()}
        passing = {name for pair in apart for name in pair}
        own = [body for body in bodies.values() if body.motion != "static" or body.name in passing]
        names = Names()
        for taken in (WORLD, *PROPERTIES["object"]):
            names.give(taken)
        named = {body.name: names.give(to_identifier(body.name)) for body in own}
        self._names = names
        merged = [body for body in bodies.values() if body.name not in named]
        self._base = Link(names.give("base", "stand", "ground"), self._file, _static_shapes(merged, shapes))
        self._root = self._base.name if self._base.shapes else WORLD
        self._link = {body.name: named.get(body.name, self._root) for body in bodies.values()}
        passes = {a: tuple(self._link[y] for x, y in apart if x == a) for a, _ in apart}
        self.links = {named[b.name]: self._made(b, named[b.name], shapes[b.path], passes.get(b.name, ())) for b in own}

    def _made(self, body: Body, name: str, shapes: tuple[Shape, ...], passes: tuple[str, ...]) -> Link:
        shapes, properties = _common_friction(shapes)
        if body.linear_damping or body.angular_damping:
            properties |= {"damping": body.linear_damping, "spin_damping": body.angular_damping}
        if body.motion == "dynamic" and body.inertia is None:
            properties["density"] = _DEFAULT_DENSITY
        shapes = shapes or (placeholder(body.inertia),)
        velocity, spin = (v if v.any() else None for v in (body.linear_velocity, body.angular_velocity))
        where = FilePlace(self._shown, element=f"`{body.path}`")
        made = Link(name, where, shapes, body.inertia, properties, body.motion != "dynamic", velocity, spin, passes)
        return replace(made, surface_velocity=body.surface_velocity if any(body.surface_velocity) else None)

    def asset(self, held: Sequence[model.Joint], faults: Faults) -> Asset:
        """Return all links and joints; unsupported ones are added to the faults."""
        if len(self.links) > MAX_LINKS:
            raise faults.stop(self._file, f"has more than {MAX_LINKS} rigid bodies", "make it simpler")
        links, made = dict(self.links), dict[str, Joint]()
        if self._base.shapes:
            shapes, properties = _common_friction(self._base.shapes)
            links = {self._base.name: replace(self._base, shapes=shapes, given=properties), **links}
            made[""] = Joint("", self._file, "fixed", WORLD, self._base.name, identity(), np.zeros(3), X)
        for joint in self._ordered_joints(held, faults):
            made[joint.name] = joint
        return Asset({WORLD: Link(WORLD, self._file), **links}, made)

    def _end(self, body: str | None) -> str:
        return self._root if body is None else self._link[body]

    def _ordered_joints(self, held: Sequence[model.Joint], faults: Faults) -> Iterator[Joint]:
        """Yield the joints, parents first; unreached links are free."""
        reached, waiting = {self._root}, list(held)
        for name, link in self.links.items():
            if link.fixed:
                reached.add(name)
                yield self._free(name)
        while waiting or not reached.issuperset(self.links):
            ready = next((j for j in waiting if reached & {self._end(j.first), self._end(j.second)}), None)
            if ready is None:
                loose = next(name for name in self.links if name not in reached)
                reached.add(loose)
                yield self._free(loose)
                continue
            waiting.remove(ready)
            turned = self._end(ready.first) not in reached
            reached |= {self._end(ready.first), self._end(ready.second)}
            try:
                yield self._joint(ready, turned, faults)
            except StageError as error:
                add_problems(error.diagnostics, self._shown, faults)

    def _pose(self, link: str) -> Pose:
        """Return the pose of a link on the stage."""
        body = next((b for b in self._bodies.values() if link in self.links and self._link[b.name] == link), None)
        return body.pose if body else identity()

    def _free(self, name: str) -> Joint:
        where = self.links[name].where
        return Joint(f"{name} free", where, "free", self._root, name, self._pose(name), np.zeros(3), X)

    def _joint(self, joint: model.Joint, turned: bool, faults: Faults) -> Joint:
        """Return a joint whose parent is its first end, or its second if `turned`; its coordinate stays the same.

        Limits of a ball joint, and a mimic, are left out. Raises StageError if it is invalid.
        """
        ends = ((joint.first, joint.first_frame), (joint.second, joint.second_frame))
        if turned:  # the axis is reversed with the ends
            ends = tuple((body, compose(frame, _OVER)) for body, frame in reversed(ends))  # type: ignore[assignment]
        (upper, above), (lower, below) = ends
        assert lower is not None
        where = FilePlace(self._shown, element=f"`{joint.path}`")
        if joint.kind == "ball" and joint.limits:
            what = "limits of ball joints are not supported in a spec"
            faults.approximate(where, what, "left out", "author cone angles of -1, or use hinges")
        if joint.mimic:
            what = "a joint that mimics another is not supported in a spec"
            faults.approximate(where, what, "it does not follow", "let the spec drive it")
        start = joint_coordinate(joint, relative_frame(self._bodies, upper, lower, above, below))
        parent, child = self._end(upper), self._end(lower)
        if upper is not None and parent == self._root:  # the base's frame is the stage's
            above = compose(self._bodies[upper].pose, above)
        if joint.kind in ("hinge", "slider"):
            place = compose(above, inverse(below))
        else:
            place = compose(inverse(self._pose(parent)), self._pose(child))
        low, high = (joint.limits if joint.kind != "ball" else None) or (-np.inf, np.inf)
        drive = joint.drive or model.Drive(0.0, 0.0)
        if drive.weightless:
            reason, remedy = "drives by acceleration are not supported in a spec", "author a force drive"
            raise StageError(reason, PrimPlace(joint.path), remedy)
        return Joint(
            self._names.give(to_identifier(joint.name)),
            where,
            joint.kind,
            parent,
            child,
            place,
            below.position,
            rotate(below.orientation, X),
            low if np.isfinite(low) else None,
            high if np.isfinite(high) else None,
            drive.damping,
            drive.stiffness,
            drive.target if drive.stiffness else None,
            drive.velocity,
            drive.max_force if np.isfinite(drive.max_force) else None,
            joint.collides,
            min(max(start, low), high) if joint.kind in ("hinge", "slider") else None,
            joint.armature,
        )


def _static_shapes(bodies: Sequence[Body], shapes: Mapping[str, tuple[Shape, ...]]) -> tuple[Shape, ...]:
    """Return all static geometry, in the frame of the stage."""
    return tuple(replace(s, pose=compose(body.pose, s.pose)) for body in bodies for s in shapes[body.path])


def _common_friction(shapes: tuple[Shape, ...]) -> tuple[tuple[Shape, ...], dict[str, float]]:
    """Return the shapes and their common friction and restitution; if these differ, each shape keeps its own."""
    frictions = {s.friction_restitution for s in shapes if s.solid and s.friction_restitution is not None}
    if len(frictions) != 1:
        return shapes, {}
    ((friction, restitution),) = frictions
    return tuple(replace(s, friction_restitution=None) for s in shapes), {
        "friction": friction,
        "restitution": restitution,
    }
