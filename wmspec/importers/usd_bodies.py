"""Rigid bodies of USD as links: their mass by UsdPhysics, and how they rub."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from pxr import Usd, UsdPhysics

from wmspec.importers import usd_looks
from wmspec.importers.model import Array, Link, Mass, Shape
from wmspec.importers.usd_prims import Prims


@dataclass
class Body:
    """A rigid body, or the base (without a prim), and what was found in it."""

    name: str
    where: str
    frame: Array
    prim: Usd.Prim | None = None
    shapes: list[Shape] = field(default_factory=list)
    colliders: list[Usd.Prim] = field(default_factory=list)


def link(prims: Prims, body: Body) -> Link:
    """The link that a body is."""
    said = usd_looks.rubs(prims, body.colliders)
    if body.prim is None:
        return Link(body.name, body.where, tuple(body.shapes), None, said)
    mass = _mass(prims, body, body.prim)
    if mass is None:
        said = {"density": _density(prims, body, body.prim), **said}
    return Link(body.name, body.where, tuple(body.shapes), mass, said)


def _mass(prims: Prims, body: Body, own: Usd.Prim) -> Mass | None:
    """The mass of a body, or of its only collider; None if it follows from a density."""
    sources = [p for p in (own, *body.colliders) if p.HasAPI(UsdPhysics.MassAPI)]
    massive = [p for p in sources if prims.number(p, "physics:mass", 0.0) > 0]
    if own in massive:
        return _weighed(prims, own, body)
    if massive and len(body.colliders) > 1:
        what = "the masses of several colliders are not supported"
        prims.faults.add(body.where, what, "author physics:mass on the rigid body instead")
    elif massive:
        return _weighed(prims, massive[0], body)
    else:
        for p in sources:
            if np.any(np.array(prims.value(p, "physics:diagonalInertia", (0, 0, 0)), float)):
                what = "moments of inertia without a mass are not supported"
                prims.faults.add(prims.where(p), what, "author physics:mass too")
    return None


def _weighed(prims: Prims, prim: Usd.Prim, body: Body) -> Mass:
    """What the PhysicsMassAPI of a body or its collider says, in the body's frame."""
    kilograms, meters = prims.kilograms, prims.meters
    mass = prims.number(prim, "physics:mass", 0.0) * kilograms
    at = np.array(prims.value(prim, "physics:centerOfMass", (np.inf,) * 3), float)
    moments = np.array(prims.value(prim, "physics:diagonalInertia", (0, 0, 0)), float)
    seen = np.linalg.inv(body.frame)
    centre = (seen @ prims.world(prim) @ (*at, 1.0))[:3] if np.isfinite(at).all() else None
    if not moments.any():
        return Mass(mass, centre)
    turn = seen[:3, :3] @ prims.rigid(prim)[0][:3, :3]
    axes = prims.value(prim, "physics:principalAxes", None)
    if axes is not None and axes.GetLength() > 0:
        turn = turn @ prims.turn(axes)
    tensor = turn @ np.diag(moments * kilograms * meters**2) @ turn.T
    return Mass(mass, centre, tensor)


def _density(prims: Prims, body: Body, prim: Usd.Prim) -> float:
    """The density of a body without a mass: its own, or that of all its colliders, or that of water."""
    own = prims.number(prim, "physics:density", 0.0)
    each = {prims.number(p, "physics:density", 0.0) or usd_looks.density(prims, p) for p in body.colliders}
    if not own and len(each) > 1:
        prims.faults.add(body.where, "its colliders have several densities", "author physics:density on the body")
    found = own or max(each, default=0.0)
    return found * prims.kilograms / prims.meters**3 if found else 1000.0
