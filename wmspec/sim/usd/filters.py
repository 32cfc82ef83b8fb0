"""Pairs that do not collide: filtered pairs, collision groups, articulations without self-collision."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, product

from pxr import Sdf, Usd, UsdPhysics

from wmspec.sim.scene.model import Body, Joint
from wmspec.sim.usd.prims import applied_schemas, existing_targets, refuse, value
from wmspec.sim.usd.stage_index import BodyPrim
from wmspec.sim.usd.substitutions import STRICT, Substitutions

Pair = tuple[str, str]
_SELF = ("physxArticulation:enabledSelfCollisions", "newton:selfCollisionEnabled")


def filtered_pairs(
    stage: Usd.Stage,
    prims: Sequence[Usd.Prim],
    groups: Sequence[Usd.Prim],
    owners: Mapping[str, BodyPrim],
    bodies: Mapping[str, Body],
    joints: Mapping[str, Joint],
    notes: Substitutions = STRICT,
) -> tuple[Pair, ...]:
    """Return the sorted pairs of names of bodies that do not collide.

    `prims` have filtered pairs or are articulation roots, `groups` are collision groups; the others are by path.

    Raises: StageError: if only some colliders of two bodies are filtered, or a target is not on the stage.
    """
    colliders = {path: [p.prim.GetPath() for p in owner.pieces if p.collides] for path, owner in owners.items()}
    blocked = {*_listed(prims, colliders, notes), *_grouped(stage, groups, colliders, notes)}
    passing = {pair for prim in prims for pair in _alone(prim, bodies, joints)}
    owner_of = {str(collider): path for path, all_ in colliders.items() for collider in all_}
    for a, b in {(owner_of[a], owner_of[b]) for a, b in blocked}:
        pairs = [(str(p), str(q)) for p, q in product(colliders[a], colliders[b])]
        if a == b or a not in bodies or b not in bodies:
            continue
        if not all(pair in blocked or pair[::-1] in blocked for pair in pairs):
            prim = stage.GetPrimAtPath(a)
            refuse(
                prim,
                f"only some of its colliders are filtered against {b}",
                "filter all colliders of both bodies, or none",
            )
        passing.add((bodies[a].name, bodies[b].name))
    order = {body.name: i for i, body in enumerate(bodies.values())}
    return tuple(sorted({(a, b) if order[a] < order[b] else (b, a) for a, b in passing}))


def _listed(
    prims: Sequence[Usd.Prim], colliders: Mapping[str, Sequence[Sdf.Path]], notes: Substitutions
) -> Iterator[Pair]:
    """Yield pairs of colliders at or below the prims of each filtered pair."""
    everything = [path for all_ in colliders.values() for path in all_]
    for prim in prims:
        for target in existing_targets(prim, "physics:filteredPairs", notes):
            mine = [path for path in everything if path.HasPrefix(prim.GetPath())]
            theirs = [path for path in everything if path.HasPrefix(Sdf.Path(target))]
            yield from ((str(a), str(b)) for a, b in product(mine, theirs))


def _grouped(
    stage: Usd.Stage, groups: Sequence[Usd.Prim], colliders: Mapping[str, Sequence[Sdf.Path]], notes: Substitutions
) -> Iterator[Pair]:
    """Yield pairs of colliders in groups that do not collide."""
    if not groups:
        return
    table = UsdPhysics.CollisionGroup.ComputeCollisionGroupTable(stage)
    everything = [path for all_ in colliders.values() for path in all_]
    members = {}
    for prim in groups:
        existing_targets(prim, "physics:filteredGroups", notes)
        for which in ("includes", "excludes"):
            existing_targets(prim, f"collection:colliders:{which}", notes)
        query = UsdPhysics.CollisionGroup(prim).GetCollidersCollectionAPI().ComputeMembershipQuery()
        members[prim.GetPath()] = [path for path in everything if query.IsPathIncluded(path)]
    for a, b in product(members, repeat=2):
        if not table.IsCollisionEnabled(a, b):
            yield from ((str(p), str(q)) for p, q in product(members[a], members[b]))


def _alone(prim: Usd.Prim, bodies: Mapping[str, Body], joints: Mapping[str, Joint]) -> Iterator[Pair]:
    """Yield all pairs of an articulation without self-collision."""
    if "PhysicsArticulationRootAPI" not in applied_schemas(prim) or all(value(prim, name, True) for name in _SELF):
        return
    root = prim.GetPath()
    inside = {body.name for path, body in bodies.items() if Sdf.Path(path).HasPrefix(root)}
    inside |= {n for path, j in joints.items() if path == str(root) for n in (j.first, j.second) if n}
    grown = -1
    while grown != len(inside):
        grown = len(inside)
        for joint in joints.values():
            if joint.first is not None and {joint.first, joint.second} & inside:
                inside |= {joint.first, joint.second}
    yield from combinations(sorted(inside), 2)
