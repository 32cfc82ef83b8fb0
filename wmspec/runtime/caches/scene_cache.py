"""Scenes of documents, read part by part: each distinct part is read once.

A part is a subtree of prims that becomes one element of the scene: an object with the cameras that ride on it, another
camera, all actions, all observations, or the lights. Its content depends on its own prims, on those above it, and on
the parts that it refers to, such as materials. The content of these is its key. Unknown parts are composed as a small
stage and read from it like any stage. Robots with assets share one key, since the names of their links depend on each
other. Their actions are read without their visual geometry.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

from wmspec.compile.layout.evaluator import Evaluator
from wmspec.compile.stage.document import Document, Prim
from wmspec.compile.stage.episode import build_document
from wmspec.compile.stage.layers import compose, without_geometry
from wmspec.compile.stage.object_cache import ObjectCache
from wmspec.core.diagnostics import WmsError
from wmspec.core.memoize import LRU
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.sim.scene.model import Body, Camera, Scene
from wmspec.sim.usd import read

_OBJECTS, _MATERIALS, _CAMERAS = "/World/Objects/", "/World/Materials/", "/World/Cameras/"
_EPISODE, _LIGHTS = "/World/Episode", "/World/Lights"
_ACTIONS, _OBSERVATIONS = f"{_EPISODE}/Actions", f"{_EPISODE}/Observations"
#: Prims above all parts. Every small stage contains them, with the part of gravity and the episode's duration.
_ABOVE = ("/World", "/World/Objects", "/World/Materials", "/World/Cameras", _LIGHTS, _ACTIONS, _OBSERVATIONS)
_FRAME = "/World/physics"
#: Prim types that can be read in parts. Prims that connect bodies (joints, filters) or are unknown are read as a whole.
_TYPES = {
    "",
    "Xform",
    "Scope",
    "PhysicsScene",
    "Material",
    "Shader",
    "DistantLight",
    "DomeLight",
    "WmsEpisode",
    "Camera",
}
_TYPES |= {"Cube", "Sphere", "Cylinder", "Cone", "Capsule", "Plane", "Mesh", "GeomSubset", "WmsObservation"}
_CONNECTING_SCHEMAS = ("PhysicsFilteredPairsAPI", "PhysicsArticulationRootAPI", "CollectionAPI")
#: Number of whole scenes cached, for a few groups whose members are each other's options.
MAX_SCENES = 64

#: The paths of the prims of every part.
_Parts = dict[str, list[str]]


class SceneCache:
    """Reads documents, and caches the most recent parts."""

    def __init__(self, remembered: int = 2048) -> None:
        self._known: LRU[bytes, Any] = LRU(remembered)
        self._objects = ObjectCache()
        self._built: LRU[tuple[object, ...], tuple[TaskSpec, Scene]] = LRU(MAX_SCENES)

    def of(self, values: Evaluator) -> Scene:
        """Return the scene of an instance, with a counterfactual if given.

        A counterfactual that only changes levels shares the scene of that sibling. Raises WmsError with all errors.
        """
        if values.change is not None and values.change.change != "levels":
            return self.scene(build_document(values, self._objects))
        key = (id(values.spec), values.key, *sorted(values.assignment.items()))
        # keeping the spec keeps its `id` unique
        return self._built.get(key, lambda: (values.spec, self.scene(build_document(values, self._objects))))[1]

    def scene(self, document: Document) -> Scene:
        """Return the scene of a document, equal to `wmspec.sim.usd.read` of the whole stage.

        Raises StageError with all errors.
        """
        parts = _parts(document)
        if parts is None:
            return read(compose(document, sources=False))
        try:
            return self._assembled(document, parts)
        except _ReadWhole:
            return read(compose(document, sources=False))

    def _assembled(self, document: Document, parts: _Parts) -> Scene:
        keys = _keys(document, parts)
        content: dict[str, Any] = {part: self._known.find(key) for part, key in keys.items()}
        missing = [part for part, known in content.items() if known is None]
        if missing:
            for part, new in self._read(document, parts, missing).items():
                content[part] = self._known.put(keys[part], new)
        objects = [content[part] for part in content if part.startswith(_OBJECTS)]
        bodies = tuple(body for known, _ in objects for body in known)
        cameras = [camera for _, riding in objects for camera in riding]
        cameras += [content[part] for part in content if part.startswith(_CAMERAS)]
        _require_independent_names(bodies, cameras, document)
        frame: Scene = content[_FRAME]
        light, background = content[_LIGHTS]
        return replace(
            frame,
            bodies=bodies,
            cameras=tuple(cameras),
            actions=content[_ACTIONS],
            observations=content[_OBSERVATIONS],
            light=light,
            background=background,
        )

    def _read(self, document: Document, parts: _Parts, missing: list[str]) -> dict[str, Any]:
        """Return the missing parts, read from a stage with these and the parts they refer to."""
        robots = _robots(document)
        near = (other for part in missing for other in _reached(document, parts, part, robots))
        looking = [part for part in parts if part.startswith(_CAMERAS)][
            :1
        ]  # else the reader would use a default camera
        needed = {_FRAME, *missing, *near, *looking}
        paths = {path for part in needed for path in parts.get(part, ())}.union(_ABOVE)
        small = Document({path: prim for path, prim in document.prims.items() if path in paths})
        try:
            scene = read(
                without_geometry(compose(small, sources=False), [part for part in robots if part not in missing])
            )
        except WmsError:
            raise _ReadWhole from None  # which reports all errors
        _require_independent_names(scene.bodies, scene.cameras, document)
        if scene.joints or scene.filtered:
            raise _ReadWhole
        return {part: _content(scene, part, parts.get(part, ()), document) for part in missing}


class _ReadWhole(Exception):
    """Control flow: the document must be read as a whole."""


def _parts(document: Document) -> _Parts | None:
    """Return the paths of every part, in the document's order, or None if the document must be read as a whole."""
    parts: _Parts = {_FRAME: [], _LIGHTS: [], _ACTIONS: [], _OBSERVATIONS: []}
    for path, prim in document.prims.items():
        part = _part(path, prim)
        if part is None:
            return None
        if part:
            parts.setdefault(part, []).append(path)
    return parts if any(prim.type == "Camera" for prim in document.prims.values()) else None


def _part(path: str, prim: Prim) -> str | None:
    """Return the part of a prim, '' if it is above all parts, or None if it connects parts."""
    if path in _ABOVE:
        return ""
    if path == _EPISODE:
        return _FRAME
    if any(schema.startswith(_CONNECTING_SCHEMAS) for schema in prim.schemas):
        return None
    for part in (_FRAME, _LIGHTS, _ACTIONS, _OBSERVATIONS):
        if path == part or path.startswith(f"{part}/"):
            return part
    whole = "/".join(path.split("/", 4)[:4])
    if whole.startswith(_CAMERAS):
        return whole if prim.type == "Camera" else None
    return whole if prim.type in _TYPES and whole.startswith((_OBJECTS, _MATERIALS)) else None


def _robots(document: Document) -> list[str]:
    """Return the robots with assets."""
    return [path for path, prim in document.prims.items() if prim.reference]


def _require_independent_names(bodies: Sequence[Body], cameras: Sequence[Camera], document: Document) -> None:
    """Raise _ReadWhole if names depend on other parts."""
    robots = tuple(f"{path}/" for path in _robots(document))
    given = {body.path.rpartition("/")[2] for body in bodies if body.path.startswith(robots)}
    others = [body.name for body in bodies if not body.path.startswith(robots)]
    names, seen = {body.name for body in bodies}, {camera.name for camera in cameras}
    if len(names) < len(bodies) or len(seen) < len(cameras) or not given.isdisjoint(others):
        raise _ReadWhole


def _keys(document: Document, parts: _Parts) -> dict[str, bytes]:
    """Return the keys of all parts except materials, which are read with the parts that use them."""
    own = {part: _bytes_of(document, paths) for part, paths in parts.items()}
    above = _bytes_of(document, [path for path in _ABOVE if path in document.prims])
    robots = _robots(document)
    keys = {}
    for part in parts:
        if not part.startswith(_MATERIALS):
            near = _reached(document, parts, part, robots)
            content = [above, part.encode(), own[part], *(own[other] for other in near)]
            keys[part] = hashlib.blake2b(b"\0".join(content), digest_size=16).digest()
    return keys


def _bytes_of(document: Document, paths: Iterable[str]) -> bytes:
    """Return the canonical content of prims, without sources."""
    try:
        return b"".join(path.encode() + b"\0" + document.prims[path].digest for path in paths)
    except ValueError:  # a value that is not a number, a text or a list of these
        raise _ReadWhole from None


def _reached(document: Document, parts: _Parts, part: str, robots: Sequence[str]) -> list[str]:
    """Return the parts that a part refers to, transitively, in order. `robots` with assets refer to each other."""
    reached, waiting = [part], [part]
    while waiting:
        for path in parts[waiting.pop()]:
            for target in _targets(document.prims[path], robots):
                near = _owner(target, parts)
                if near not in reached:
                    reached.append(near)
                    waiting.append(near)
    return reached[1:]


def _targets(prim: Prim, robots: Sequence[str]) -> Sequence[str]:
    return (*robots, *prim.targets) if prim.reference else prim.targets


def _owner(path: str, parts: _Parts) -> str:
    whole = "/".join(path.split("/", 4)[:4])
    if whole not in parts:
        raise _ReadWhole  # its target cannot be read separately
    return whole


def _content(scene: Scene, part: str, paths: Sequence[str], document: Document) -> Any:
    """Return the scene elements of a part."""
    match part:
        case _ if part == _FRAME:
            return replace(scene, bodies=(), cameras=(), actions=(), observations=())
        case _ if part == _LIGHTS:
            return scene.light, scene.background
        case _ if part == _ACTIONS:
            return scene.actions
        case _ if part == _OBSERVATIONS:
            return scene.observations
        case _ if part.startswith(_CAMERAS):
            return _named(scene.cameras, part)
    bodies = tuple(body for body in scene.bodies if body.path == part or body.path.startswith(f"{part}/"))
    for body in bodies:
        if body.name != body.path.rpartition("/")[2] and not document.prims[part].reference:
            raise _ReadWhole  # its name depends on other names
    riding = [path for path in paths if document.prims[path].type == "Camera"]
    return bodies, tuple(_named(scene.cameras, path) for path in riding)


def _named(cameras: Sequence[Camera], path: str) -> Camera:
    """Return the camera with the name of its prim."""
    named = [camera for camera in cameras if camera.name == path.rpartition("/")[2]]
    if len(named) != 1:
        raise _ReadWhole
    return named[0]
