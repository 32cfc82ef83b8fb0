"""Checks shapes and inertias of links: flat colliders, and inertias that no body of that mass and size can have.

The moments of a body of mass m within a ball of radius r about its centre of mass are at most m r², and none exceeds
the sum of the others.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from wmspec.core.diagnostics import WmsError
from wmspec.lang.importers.mesh_files import check_mesh_file
from wmspec.lang.importers.model import Asset, Faults, Link, MeshFile, Shape
from wmspec.sim.scene.model import Array, Inertia, Pose
from wmspec.sim.scene.model.transform import apply, identity
from wmspec.sim.scene.physics.gyration import excess_text, gyration_excess, is_implausible, is_impossible
from wmspec.sim.scene.physics.inertia import inertia
from wmspec.sim.shapes import Mesh
from wmspec.sim.shapes import Shape as Solid
from wmspec.sim.shapes.facets import tessellate
from wmspec.sim.shapes.hull import hull

_NO_FACES = np.empty((0, 3), np.int32)

#: Relative excess of a moment over the sum of the others that rounding explains.
_ROUNDING = 1e-3
#: Least extent (m) of the box that stands in for geometry without volume.
_THICKNESS = 1e-3
#: Radius (m) of the ball that stands in for a link without geometry.
_BALL = 0.05
#: Ratio of moments above which no percentage is given.
_FAR = 11.0


def checked(asset: Asset, folder: Path, faults: Faults) -> Asset:
    """Return the asset without flat colliders, and with plausible inertias; each change is reported."""
    links = {
        name: _with_inertia(_without_flat(link, folder, faults), folder, faults) for name, link in asset.links.items()
    }
    return Asset(links, asset.joints)


def _without_flat(link: Link, folder: Path, faults: Faults) -> Link:
    """Return a link whose flat meshes do not collide."""
    shapes = list[Shape]()
    for shape in link.shapes:
        flat = shape.solid and isinstance(shape.form, MeshFile) and _is_flat(mesh_size(folder, shape.form))
        if flat:
            help = "give it a thickness, or a box"
            faults.approximate(link.where, "a flat mesh cannot collide", "it is drawn only", help)
        if not flat or shape.drawn:
            shapes.append(replace(shape, solid=shape.solid and not flat))
    if link.shapes and not any(s.solid for s in shapes) and any(s.solid for s in link.shapes) and link.mass is None:
        return replace(link, shapes=tuple(shapes), massless=True)
    return replace(link, shapes=tuple(shapes))


def _is_flat(size: MeshSize | None) -> bool:
    return size is not None and size.hull is None


def _with_inertia(link: Link, folder: Path, faults: Faults) -> Link:
    """Return a link with the inertia of its shapes if its own is impossible."""
    mass = link.mass
    if mass is None or link.fixed:
        return link
    moments = np.sort(mass.moments)
    excess = float(moments[2] / max(moments[0] + moments[1], 1e-300))
    reach = _reach(link, folder, mass.center)
    if moments[2] <= 0:
        what = f"its mass is {mass.mass:.3g} kg and its inertia 0"
    elif moments[0] <= 0 or excess > 1 + _ROUNDING:
        above = f"{100 * (excess - 1):.0f} %" if moments[0] > 0 and excess < _FAR else "far"
        what = f"no body has its moments of inertia: the largest is {above} above the others' sum"
    elif is_implausible(times := gyration_excess(mass.mass, moments, reach)):
        what = excess_text(times)
        if not is_impossible(times):
            faults.approximate(link.where, what, "it is used", "correct it")
            return replace(link, mass=_rounded(mass))
    else:
        return replace(link, mass=_rounded(mass))
    made, taken = _of_shapes(link, folder, mass), "that of its shapes is used"
    if made is None:
        made, taken = _ball(mass), f"that of a ball of {100 * _BALL:g} cm is used"
    faults.approximate(link.where, what, taken, "correct it; `inertia: file` keeps it")
    return replace(link, mass=made, own_inertia=mass)


def _rounded(mass: Inertia) -> Inertia:
    """Return an inertia of which no moment exceeds the sum of the others."""
    moments = mass.moments
    most = moments.sum() - moments.max()
    return mass if moments.max() <= most * (1 + 1e-6) else replace(mass, moments=np.minimum(moments, most))


def _reach(link: Link, folder: Path, center: Array) -> float:
    """Return the distance (m) of the farthest point of the shapes from a point; 0 if a shape is unknown."""
    farthest = 0.0
    for shape in link.shapes:
        points = _points(shape, folder)
        if points is None:
            return 0.0
        farthest = max(farthest, float(np.linalg.norm(points - center, axis=1).max()))
    return farthest if any(s.solid or s.drawn for s in link.shapes) else 0.0


def _points(shape: Shape, folder: Path) -> Array | None:
    """Return points (n, 3) m on a shape, in the link's frame."""
    if isinstance(shape.form, MeshFile):
        size = mesh_size(folder, shape.form)
        own = np.array(shape.form.corners) if shape.form.corners else None if size is None else size.points
    else:
        own = tessellate(shape.form).points
    return None if own is None else np.array([apply(shape.pose, p) for p in own]).reshape(-1, 3)


def _of_shapes(link: Link, folder: Path, mass: Inertia) -> Inertia | None:
    """Return the inertia of the shapes of a link for its mass, about its centre of mass if that is within them."""
    shapes = [s for s in link.shapes if s.solid] or list(link.shapes)
    solids = list[tuple[Solid, Pose]]()
    points = list[Array]()
    for shape in shapes:
        size = mesh_size(folder, shape.form) if isinstance(shape.form, MeshFile) else None
        form = shape.form if not isinstance(shape.form, MeshFile) else size.hull if size else None
        if form is not None:
            solids.append((form, shape.pose))
        own = _points(shape, folder)
        if own is not None:
            points.append(own)
    if not points or not any(s.solid or s.drawn for s in shapes):
        return None
    every = np.concatenate(points)
    low, high = every.min(axis=0), every.max(axis=0)
    try:
        whole = sum(form.volume for form, _ in solids)
        made = inertia([(form, pose, mass.mass * form.volume / whole) for form, pose in solids])
    except (WmsError, ZeroDivisionError):
        made = _box(mass.mass, low, high)
    inside = bool((mass.center >= low - _THICKNESS).all() and (mass.center <= high + _THICKNESS).all())
    return replace(made, center=mass.center) if inside else made


def _ball(mass: Inertia) -> Inertia:
    """Return the inertia of a small ball."""
    return Inertia(mass.mass, mass.center, identity().orientation, np.full(3, 0.4 * mass.mass * _BALL**2))


def _box(kg: float, low: Array, high: Array) -> Inertia:
    """Return the inertia of a box between two corners."""
    squares = np.maximum(high - low, _THICKNESS) ** 2
    return Inertia(kg, (low + high) / 2, identity().orientation, kg / 12 * (squares.sum() - squares))


@dataclass(frozen=True)
class MeshSize:
    """The extreme points (n, 3) m of a mesh; `hull` is None if they lie in a plane."""

    points: Array
    hull: Mesh | None


def mesh_size(folder: Path, form: MeshFile) -> MeshSize | None:
    """Return the size of a scaled mesh, or None if it cannot be read or lies in a stage."""
    if "#" in form.file:
        return None
    path = folder / form.file
    try:
        status = path.stat()
        points = _file_points(str(path), status.st_mtime_ns, status.st_size)
    except Exception:  # noqa: BLE001  whoever loads the mesh reports it
        return None
    scaled = points * np.asarray(form.scale, np.float64)
    try:
        solid = hull(scaled)
    except WmsError:
        return MeshSize(scaled, None)
    corners = np.asarray(solid.vertices, np.float64)
    return MeshSize(corners, Mesh(corners, _NO_FACES))


@lru_cache(maxsize=512)
def _file_points(path: str, _changed: int, _size: int) -> Array:
    """Return the points (n, 3) m of a file, those of its hull if it has one."""
    import trimesh

    check_mesh_file(Path(path))
    loaded: Any = trimesh.load(path, force="mesh", process=False, skip_materials=True)
    points = np.asarray(loaded.vertices, np.float64)
    if path.lower().endswith(".dae"):
        points = points * trimesh.units.unit_conversion(loaded.units, "m")
    if not len(points) or not np.isfinite(points).all():
        raise ValueError("it has no finite points")
    try:
        return np.asarray(hull(points).vertices, np.float64)
    except WmsError:
        return points
