"""Prepares MJCF for MuJoCo: includes resolved, files read within the spec's folder, irrelevant elements removed.

MuJoCo receives a text with one element a line and the contents of the mesh files, and opens no file itself. The lines
lead back from its messages and objects to the places in the files.
"""

from __future__ import annotations

import math
import posixpath
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

from wmspec.core.diagnostics import WmsError
from wmspec.core.limits import FILE_BYTES
from wmspec.core.safe_io import read_bytes
from wmspec.lang.importers.markup import Element, read_xml
from wmspec.lang.importers.mesh_files import check_mesh_file
from wmspec.lang.importers.model import MAX_LINKS, MAX_SHAPES, Faults

#: Resolves a file that an element names to a path relative to the spec; '' if it is missing, which is reported.
FileResolver = Callable[[Element, str, bool], str]

#: Maximum depth and number of included files.
_MAX_INCLUDES = 100
#: Sections that bear neither on motion nor on pictures of the asset, or that the spec sets.
_IGNORED = ("size", "visual", "statistic", "sensor", "custom", "extension")
#: Elements of bodies without an effect here.
_MARKS = ("light", "camera", "site", "plugin")
_SOFT = ("flexcomp", "composite", "flex")
_FILES = ("meshdir", "texturedir", "assetdir", "strippath")
#: Settings of `compiler` that do not apply: links keep their names, and visual geometry is drawn.
_SETTINGS = (*_FILES, "fusestatic", "discardvisual", "usethread")
#: Gravity (m/s²) of a spec that sets none.
_GRAVITY = 9.81
#: What a keyframe sets at the start.
_START = frozenset({"qpos", "qvel", "act", "ctrl", "mpos", "mquat"})
_ACTUATED = "actuators that act on no joint are not supported"


@dataclass
class Source:
    """The text for MuJoCo, its elements by line, and the mesh files by their names in the text.

    `files` gives the path of each mesh file relative to the spec, `textured` the materials with an image by name.
    """

    root: Element
    assets: dict[str, bytes] = field(default_factory=dict)
    files: dict[str, str] = field(default_factory=dict)
    elements: list[Element] = field(default_factory=list)
    textured: dict[str, Element] = field(default_factory=dict)

    def text(self) -> str:
        """Return the text, with one element a line."""
        self.elements, lines = [], list[str]()

        def write(e: Element) -> None:
            self.elements.append(e)
            attributes = (f" {name}={quoteattr(text)}" for name, text in e.attributes.items() if self._is_safe(e, name))
            lines.append(f"<{e.tag}{''.join(attributes)}>".replace("\n", " "))
            for child in e.children:
                write(child)
            lines[-1] += f"</{e.tag}>"

        write(self.root)
        return "\n".join(lines)

    def _is_safe(self, e: Element, name: str) -> bool:
        """Whether an attribute belongs to MuJoCo, and names no file but a mesh in memory."""
        return ":" not in name and (not name.startswith("file") or e.attributes[name] in self.assets)

    def element(self, line: int) -> Element:
        """Return the element on a line (from 1) of the text."""
        return self.elements[min(max(line, 1), len(self.elements)) - 1]


class Preparation:
    """Prepares one file; `shown` is its path relative to the spec's `folder`."""

    def __init__(self, folder: Path, shown: str, find: FileResolver, faults: Faults) -> None:
        self._folder, self._home = folder, posixpath.dirname(shown)
        self._find, self._faults = find, faults
        self._count = 0

    def source(self, root: Element) -> Source:
        """Return the source of the root element. Raises UnreadableAsset if it is invalid."""
        whole = self._included(root, 0)
        sections = [s for e in whole.children if (s := self._section(e)) is not None]
        made = Source(Element("mujoco", {}, root.line, root.file, sections))
        if not any(e.tag == "worldbody" for e in sections):
            raise self._faults.stop(root.where, "has no `worldbody`", "is this the right file?")
        self._bounded(root, sections)
        materials = (e for assets in whole.all("asset") for e in assets.all("material"))
        made.textured = {e.attributes.get("name", ""): e for e in materials if "texture" in e.attributes or e.children}
        self._files(whole, made)
        return made

    # ------------------------------------------------------------ includes

    def _included(self, e: Element, depth: int) -> Element:
        """Return an element with the content of included files in place of `include`."""
        children: list[Element] = []
        for child in e.children:
            if child.tag == "include":
                children += self._of_include(child, depth)
            else:
                children.append(self._included(child, depth))
        return Element(e.tag, e.attributes, e.line, e.file, children)

    def _of_include(self, e: Element, depth: int) -> list[Element]:
        self._count += 1
        if self._count > _MAX_INCLUDES:
            raise self._faults.stop(e.where, f"has more than {_MAX_INCLUDES} includes", "make it simpler")
        name = self._find(e, e.attributes.get("file", ""), False)
        if not name:
            return []
        return self._included(read_xml(self._folder / name, name, self._faults), depth + 1).children

    # ------------------------------------------------------------ sections

    def _section(self, e: Element) -> Element | None:
        """Return a section without what does not matter, or None."""
        match e.tag:
            case tag if tag in _IGNORED or ":" in tag:
                return None
            case "compiler":
                return Element(e.tag, {k: v for k, v in e.attributes.items() if k not in _SETTINGS}, e.line, e.file)
            case "default":
                return self._defaults(e)
            case "asset":
                return self._assets(e)
            case "worldbody":
                return self._body(e)
            case "actuator":
                return self._actuators(e)
            case "contact":
                return self._contact(e)
            case "option":
                return self._option(e)
            case "keyframe" | "equality" | "tendon" | "deformable":
                report = self._keyframes if e.tag == "keyframe" else self._left_out
                report(e)
                return None
        return e

    def _option(self, e: Element) -> Element:
        """Return the flag of contacts. Report other settings that would change motion, and gravity unlike a spec's."""
        gravity = _numbers(e.attributes.get("gravity", ""))
        if len(gravity) == 3 and math.dist(gravity, (0.0, 0.0, -_GRAVITY)) > 0.01 * _GRAVITY:
            what = f"a gravity of ({', '.join(f'{x:g}' for x in gravity)}) m/s² in a file is not supported"
            self._faults.approximate(e.where, what, "that of the spec", "write `world { gravity: ... }` in a spec")
        for name in ("density", "viscosity", "wind"):
            if any(word not in ("0", "0.0") for word in e.attributes.get(name, "").split()):
                self._faults.approximate(
                    e.where, f"`{name}` of the medium is not supported", "left out", "set `damping`"
                )
        for flag in e.all("flag"):
            for name in ("gravity", "limit", "spring", "damper", "actuation"):
                if flag.attributes.get(name) == "disable":
                    what = f"a world without `{name}` is not supported"
                    self._faults.approximate(flag.where, what, "left out", "change the elements themselves")
        flags = ((f, f.attributes["contact"]) for f in e.all("flag") if "contact" in f.attributes)
        kept = [Element("flag", {"contact": said}, f.line, f.file) for f, said in flags]
        return Element(e.tag, {}, e.line, e.file, kept)

    def _defaults(self, e: Element) -> Element:
        dropped = ("site", "camera", "light", "tendon", "equality", "skin", *_SOFT)
        children = [
            self._defaults(c) if c.tag == "default" else self._material(c) for c in e.children if c.tag not in dropped
        ]
        return Element(e.tag, e.attributes, e.line, e.file, children)

    def _material(self, e: Element) -> Element:
        """Return a material without its texture, which is reported; other elements are unchanged."""
        if e.tag != "material" or not ("texture" in e.attributes or e.children):
            return e
        return Element(e.tag, {k: v for k, v in e.attributes.items() if k != "texture"}, e.line, e.file)

    def _assets(self, e: Element) -> Element:
        children: list[Element] = []
        for child in e.children:
            if child.tag in ("mesh", "material"):
                children.append(self._material(Element(child.tag, dict(child.attributes), child.line, child.file)))
            elif child.tag == "hfield":  # its geoms are left out
                kept = {"name": child.attributes.get("name", "") or _stem(child), "nrow": "2", "ncol": "2"}
                children.append(Element("hfield", {**kept, "size": "1 1 1 1"}, child.line, child.file))
            elif child.tag == "model":
                self._faults.add(
                    child.where, "`attach` of other models is not supported", "use `include`, or two assets"
                )
        return Element(e.tag, {}, e.line, e.file, children)

    def _body(self, e: Element) -> Element:
        children: list[Element] = []
        for child in e.children:
            if child.tag in _SOFT:
                self._faults.add(child.where, "soft bodies are not supported", "remove it")
            elif child.tag in ("body", "frame", "replicate"):
                children.append(self._body(child))
            elif child.tag not in _MARKS and ":" not in child.tag:
                plain = Element(child.tag, child.attributes, child.line, child.file)
                children.append(plain)
        return Element(e.tag, e.attributes, e.line, e.file, children)

    def _actuators(self, e: Element) -> Element:
        children: list[Element] = []
        for child in e.children:
            if "joint" in child.attributes and child.tag != "plugin":
                children.append(Element(child.tag, child.attributes, child.line, child.file))
            elif ":" not in child.tag:
                self._faults.approximate(child.where, _ACTUATED, "left out", "let the spec exert a `force`")
        return Element(e.tag, {}, e.line, e.file, children)

    def _contact(self, e: Element) -> Element:
        for pair in e.all("pair"):
            what = "contacts of two geoms with properties of their own are not supported"
            self._faults.approximate(pair.where, what, "they collide as other geoms do", "set `friction` of the links")
        return Element(e.tag, {}, e.line, e.file, e.all("exclude"))

    def _keyframes(self, section: Element) -> None:
        """Report keyframes that would change the start."""
        for e in section.all("key"):
            if _START.intersection(e.attributes):
                help = "set `start` of the joints, and `velocity` of the links"
                self._faults.approximate(e.where, "keyframes are not supported", "the start is that without them", help)

    def _left_out(self, section: Element) -> None:
        for e in section.children:
            if e.tag in _SOFT:
                self._faults.add(e.where, "soft bodies are not supported", "remove it")
            elif e.tag != "skin" and ":" not in e.tag:
                kind = f"`{e.tag}` constraints" if section.tag == "equality" else f"`{e.tag}` tendons"
                self._faults.approximate(e.where, f"{kind} are not supported", "left out", "remove it")

    # ------------------------------------------------------------ bounds

    def _bounded(self, root: Element, sections: list[Element]) -> None:
        """Stop if replication would make too many bodies or geoms, before MuJoCo makes them."""
        bodies = sum(n for s in sections if s.tag == "worldbody" for n in self._counts(s, 1, "body"))
        geoms = sum(n for s in sections if s.tag == "worldbody" for n in self._counts(s, 1, "geom"))
        if bodies > MAX_LINKS or geoms > MAX_SHAPES:
            what = f"has more than {MAX_LINKS} bodies or {MAX_SHAPES} geoms"
            raise self._faults.stop(root.where, what, "make it simpler")

    def _counts(self, e: Element, times: int, tag: str) -> Iterator[int]:
        for child in e.children:
            count = times
            if child.tag == "replicate":
                given = child.attributes.get("count", "1")
                count *= min(int(given), MAX_SHAPES + 1) if given.isdigit() and len(given) < 10 else 1
            if child.tag == tag:
                yield count
            yield from self._counts(child, min(count, 10**9), tag)

    # ------------------------------------------------------------ files

    def _files(self, whole: Element, source: Source) -> None:
        """Read the files of all meshes, and name them in the text by numbers."""
        settings: dict[str, str] = {}
        for compiler in whole.all("compiler"):
            settings |= compiler.attributes
        folder = settings.get("meshdir", settings.get("assetdir", ""))
        strip = settings.get("strippath") == "true"
        for mesh in (m for assets in source.root.all("asset") for m in assets.all("mesh")):
            named = mesh.attributes.get("file", "")
            if not named:
                what = "meshes without a file are not supported"
                self._faults.add(mesh.where, what, "save it as .obj and name it in `file`")
                continue
            mesh.attributes.setdefault("name", _stem(mesh))
            named = posixpath.basename(named.replace("\\", "/")) if strip else named
            path = self._find(mesh, posixpath.join(folder, named), True)
            if not (path and self._read(mesh, path, source)):
                mesh.attributes["vertex"] = "0 0 0 1 0 0 0 1 0 0 0 1"  # to find further faults

    def _read(self, mesh: Element, path: str, source: Source) -> bool:
        """Add the content of a mesh file in a format that MuJoCo reads; whether it can be read."""
        name = f"{len(source.files)}{posixpath.splitext(path)[1].lower()}"
        try:
            check_mesh_file(self._folder / path)
            content, ending = _for_mujoco(self._folder / path)
        except WmsError as error:
            self._faults.add(mesh.where, f"`{path}` {error.diagnostics[0].message}", error.diagnostics[0].help)
            return False
        except Exception as error:  # noqa: BLE001  a parser of files of others can fail in any way
            self._faults.add(mesh.where, f"`{path}` is broken: {str(error)[:200]}", "export it again")
            return False
        name = posixpath.splitext(name)[0] + ending
        mesh.attributes["file"] = name
        source.assets[name], source.files[name] = content, path
        return True


def _numbers(text: str) -> list[float]:
    """Return the numbers of an attribute; none if they are no numbers."""
    try:
        return [float(word) for word in text.split()]
    except ValueError:
        return []


def _stem(e: Element) -> str:
    """Return the name that MuJoCo gives an unnamed asset: that of its file."""
    return posixpath.splitext(posixpath.basename(e.attributes.get("file", "")))[0]


def _for_mujoco(path: Path) -> tuple[bytes, str]:
    """Return the content of a mesh file and its ending; formats that MuJoCo does not read become OBJ."""
    content, ending = read_bytes(path, FILE_BYTES), path.suffix.lower()
    if ending == ".obj" or (ending == ".stl" and not content[:6].lower().startswith(b"solid ")):
        return content, ending
    import trimesh

    loaded: Any = trimesh.load(path, force="mesh", process=False, skip_materials=True)
    if ending == ".dae":
        loaded.apply_scale(trimesh.units.unit_conversion(loaded.units, "m"))
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in loaded.vertices.tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in loaded.faces.tolist()]
    return "\n".join(lines).encode(), ".obj"
