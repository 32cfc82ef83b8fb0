"""Scenes of documents, read part by part: what was read before, in whatever stage, is not read again.

A part is a subtree of prims that becomes one thing of the scene: an object and the cameras that ride on it, another
camera, all actions, all observations, the lights. What it is read as depends on its own prims, on those above it and on
the parts that it points to, as an object points to its materials: their content is its key. The parts that are not
known are composed as a small stage of their own, and read from it as any stage is. Robots that are made of files are
known together, since the names of their links depend on each other; what they do is read without what they look like.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

from wmspec.compile.layout.values import Values
from wmspec.compile.stage.document import Document, Prim
from wmspec.compile.stage.episode import built
from wmspec.compile.stage.layers import bare, compose
from wmspec.compile.stage.object_cache import ObjectCache
from wmspec.core.diagnostics import WmsError
from wmspec.core.memoize import LRU
from wmspec.lang.check.ir.ir import TaskSpec
from wmspec.sim.scene.model import Body, Camera, Scene
from wmspec.sim.usd import read

_OBJECTS, _MATERIALS, _CAMERAS = "/World/Objects/", "/World/Materials/", "/World/Cameras/"
_EPISODE, _LIGHTS = "/World/Episode", "/World/Lights"
_ACTIONS, _OBSERVATIONS = f"{_EPISODE}/Actions", f"{_EPISODE}/Observations"
#: The prims above all parts, which are in every small stage, as is the part of gravity and the episode's duration.
_ABOVE = ("/World", "/World/Objects", "/World/Materials", "/World/Cameras", _LIGHTS, _ACTIONS, _OBSERVATIONS)
_FRAME = "/World/physics"
#: What ties bodies together is read as a whole: joints, filters, and what is not known here.
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
_TYING = ("PhysicsFilteredPairsAPI", "PhysicsArticulationRootAPI", "CollectionAPI")
#: So many whole scenes are remembered: those of a few groups whose members are each other's options.
SIBLINGS = 64

#: The paths of the prims of every part.
_Parts = dict[str, list[str]]


class SceneCache:
    """Reads documents, and remembers the latest parts of them."""

    def __init__(self, remembered: int = 2048) -> None:
        self._known: LRU[bytes, Any] = LRU(remembered)
        self._objects = ObjectCache()
        self._built: LRU[tuple[object, ...], tuple[TaskSpec, Scene]] = LRU(SIBLINGS)

    def of(self, values: Values) -> Scene:
        """The scene of an instance, or of what it would be under a counterfactual.

        Other levels make it one of its siblings, whose scene it has, whichever of them was built first. Raises WmsError
        with all that is wrong.
        """
        if values.change is not None and values.change.change != "levels":
            return self.scene(built(values, self._objects))
        key = (id(values.spec), values.key, *sorted(values.assignment.items()))
        # the spec stays, and so its `id`
        return self._built.get(key, lambda: (values.spec, self.scene(built(values, self._objects))))[1]

    def scene(self, document: Document) -> Scene:
        """The scene of a document, as `wmspec.sim.usd.read` reads it from the whole stage.

        Raises StageError with all that is wrong.
        """
        parts = _parts(document)
        if parts is None:
            return read(compose(document, sources=False))
        try:
            return self._assembled(document, parts)
        except _Whole:
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
        _alone(bodies, cameras, document)
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
        """What the parts that are missing become, read from a stage of these and what they point to."""
        robots = _robots(document)
        near = (other for part in missing for other in _reached(document, parts, part, robots))
        looking = [part for part in parts if part.startswith(_CAMERAS)][:1]  # else one that shows all would be found
        wanted = {_FRAME, *missing, *near, *looking}
        paths = {path for part in wanted for path in parts.get(part, ())}.union(_ABOVE)
        small = Document({path: prim for path, prim in document.prims.items() if path in paths})
        try:
            scene = read(bare(compose(small, sources=False), [part for part in robots if part not in missing]))
        except WmsError:
            raise _Whole from None  # where all that is wrong is told
        _alone(scene.bodies, scene.cameras, document)
        if scene.joints or scene.filtered:
            raise _Whole
        return {part: _content(scene, part, parts.get(part, ()), document) for part in missing}


class _Whole(Exception):
    """No error: the document is read as a whole."""


def _parts(document: Document) -> _Parts | None:
    """The paths of every part, in the document's order; None if the document has to be read as a whole."""
    parts: _Parts = {_FRAME: [], _LIGHTS: [], _ACTIONS: [], _OBSERVATIONS: []}
    for path, prim in document.prims.items():
        part = _part(path, prim)
        if part is None:
            return None
        if part:
            parts.setdefault(part, []).append(path)
    return parts if any(prim.type == "Camera" for prim in document.prims.values()) else None


def _part(path: str, prim: Prim) -> str | None:
    """The part that a prim belongs to, empty if it is above all of them; None if it ties parts together."""
    if path in _ABOVE:
        return ""
    if path == _EPISODE:
        return _FRAME
    if any(schema.startswith(_TYING) for schema in prim.schemas):
        return None
    for part in (_FRAME, _LIGHTS, _ACTIONS, _OBSERVATIONS):
        if path == part or path.startswith(f"{part}/"):
            return part
    whole = "/".join(path.split("/", 4)[:4])
    if whole.startswith(_CAMERAS):
        return whole if prim.type == "Camera" else None
    return whole if prim.type in _TYPES and whole.startswith((_OBJECTS, _MATERIALS)) else None


def _robots(document: Document) -> list[str]:
    """The robots that are made of files."""
    return [path for path, prim in document.prims.items() if prim.reference]


def _alone(bodies: Sequence[Body], cameras: Sequence[Camera], document: Document) -> None:
    """Read the document as a whole if names depend on more than the parts that they are in."""
    robots = tuple(f"{path}/" for path in _robots(document))
    given = {body.path.rpartition("/")[2] for body in bodies if body.path.startswith(robots)}
    others = [body.name for body in bodies if not body.path.startswith(robots)]
    names, seen = {body.name for body in bodies}, {camera.name for camera in cameras}
    if len(names) < len(bodies) or len(seen) < len(cameras) or not given.isdisjoint(others):
        raise _Whole


def _keys(document: Document, parts: _Parts) -> dict[str, bytes]:
    """The keys of all parts but the materials, which are read with what they are bound to."""
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
    """What tells prims from others, by what they say, without whence it comes."""
    try:
        return b"".join(path.encode() + b"\0" + document.prims[path].digest for path in paths)
    except ValueError:  # a value that is no number, text or list of them
        raise _Whole from None


def _reached(document: Document, parts: _Parts, part: str, robots: Sequence[str]) -> list[str]:
    """The other parts that a part points to, directly or not, in order. `robots` made of files point to each other."""
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
        raise _Whole  # it points to nothing that could be read alone
    return whole


def _content(scene: Scene, part: str, paths: Sequence[str], document: Document) -> Any:
    """What a part has become in a scene."""
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
            raise _Whole  # its name depends on those of others
    riding = [path for path in paths if document.prims[path].type == "Camera"]
    return bodies, tuple(_named(scene.cameras, path) for path in riding)


def _named(cameras: Sequence[Camera], path: str) -> Camera:
    """The camera with the name of its prim."""
    named = [camera for camera in cameras if camera.name == path.rpartition("/")[2]]
    if len(named) != 1:
        raise _Whole
    return named[0]
