"""Registers meshes as templates of a library, with scale, collision shape, mass, licence and thumbnail."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ValidationError

from wmspec.api.loading import TextCheck
from wmspec.core.diagnostics import SpecError, WmsError
from wmspec.core.limits import FILE_BYTES
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import read_bytes
from wmspec.lang.check.tables.vocabulary import ASSETS, FILES, MESH_UNITS, Y_UP
from wmspec.lang.importers.blocks import to_identifier
from wmspec.lang.importers.mesh_files import check_mesh_file

if TYPE_CHECKING:
    from wmspec.api.task import Task

LIBRARY, RECORD, THUMBNAILS = "things.wms", "things.json", "thumbnails"
"""Files in the folder: the library, what it is written from, and the folder of pictures."""

#: Names of files and folders that do not name the object, as in YCB and Google Scanned Objects.
_GENERIC = re.compile(
    r"(non)?textured(_\w+)?|models?|mesh(es)?|visual|collision|google_\d+k|clouds|tsdf|poisson|object"
)
#: Share of its hull that a mesh fills if it collides as the hull.
MIN_CONVEXITY = 0.9
#: Plausible sizes (m) of an object.
MIN_SIZE, MAX_SIZE = 2e-3, 10.0
#: Maximum number of meshes of a call.
MAX_THINGS = 500
#: Side (px) of a thumbnail.
THUMBNAIL = 256
_TEXT = re.compile(r"[^\"\\\n\r]{1,300}")
_SCENE = """task thumbnail : custom {{
  world {{ background: white }}
  light sun {{ diffuse: 0.8  ambient: 0.5 }}
  object ground {{ shape: box  size: (40 m, 40 m, 10 cm)  at: (0, 0, -5 cm)  fixed: true  color: mist }}
  object thing : {name} {{ on: ground at (0, 0) }}
  camera front {{ at: ({x} m, {y} m, {z} m)  look_at: (0, 0, {middle} m)  fov: 30 deg }}
  observe front at [0 s]
  horizon 0.1 s
}}
"""


class Thing(BaseModel, extra="forbid", frozen=True):
    """A registered mesh. `mass` is in kg, `size` in m, along the axes of the upright object."""

    name: str
    file: str
    units: str = "m"
    up: str = "z"
    collision: str = "hull"
    mass: float | None = None
    density: float | None = None
    license: str = ""
    source: str = ""
    size: tuple[float, float, float]

    @property
    def template(self) -> str:
        """The template of the library."""
        weight = f"mass: {self.mass:g} kg" if self.mass is not None else f"density: {self.density or 600:g} kg/m^3"
        named = self.name.replace("_", " ")
        lines = (
            f"# {' x '.join(f'{100 * edge:.3g}' for edge in self.size)} cm; licence: {self.license or 'unknown'}",
            f"template {self.name} {{",
            f'  file: "{self.file}"  units: {self.units}  up: {self.up}  collision: {self.collision}',
            f'  {weight}  called: "{named}"',
            "}",
        )
        return "\n".join(lines)


class _Record(BaseModel, extra="forbid"):
    """What a library of things is written from."""

    format: int = 1
    things: tuple[Thing, ...] = ()


@dataclass(frozen=True)
class ThingOptions:
    """How meshes are registered.

    `units` and `up` of the meshes, by default metres and z, or y for glTF. `collision`: a word of the language, or
    `auto`: the hull if the mesh fills 90 % of it, else convex pieces. `masses` (kg) by name; others follow from
    `density` (kg/m³). `license` is an SPDX identifier.
    """

    units: str = ""
    up: str = ""
    collision: str = "auto"
    masses: Mapping[str, float] | None = None
    density: float = 600.0
    license: str = ""
    source: str = ""


def add_things(paths: Sequence[Path], options: ThingOptions, folder: Path | None = None) -> tuple[Path, list[Thing]]:
    """Add mesh files, and those below folders, to the library `things.wms` in `folder`; return its path and the things.

    By default the library is in the first folder, or in that of the first file. Raises WmsError for a mesh that cannot
    be read, has an implausible size or lies outside the library's folder.
    """
    if not paths:
        raise WmsError("there is no file to add")
    home = (folder or (paths[0] if paths[0].is_dir() else paths[0].parent)).resolve()
    for text, what in ((options.license, "licence"), (options.source, "source")):
        if text and not _TEXT.fullmatch(text):
            raise WmsError(f"the {what} is one line without quotes, of at most 300 characters")
    files = list(_meshes(paths))
    known = {thing.file: thing for thing in _read(home).things}
    taken = {thing.name for thing in known.values()}
    made = list[Thing]()
    for path in files:
        file = _relative(path, home)
        name = known[file].name if file in known else _unique(_name(path), taken)
        taken.add(name)
        made.append(_thing(path, file, name, options))
    masses = dict(options.masses or {})
    if unknown := masses.keys() - {thing.name for thing in made}:
        names = ", ".join(f"`{thing.name}`" for thing in made[:20])
        raise WmsError(f"there is no `{min(unknown)}` to have a mass", help=f"the names are {names}")
    known |= {thing.file: thing for thing in made}
    record = _Record(things=tuple(sorted(known.values(), key=lambda thing: thing.name)))
    (home / RECORD).write_text(record.model_dump_json(indent=1) + "\n", encoding="utf-8")
    (home / LIBRARY).write_text(_library(record.things), encoding="utf-8")
    return home / LIBRARY, made


def thumbnail(library: Path, thing: Thing, engine: str) -> Path:
    """Draw a thing on a ground; return the path of the picture. Raises WmsError if the language refuses it."""
    reach = max(thing.size)
    view = {"x": 1.6 * reach, "y": -2.4 * reach, "z": thing.size[2] / 2 + 1.3 * reach, "middle": thing.size[2] / 2}
    numbers = {name: f"{number:.6g}" for name, number in view.items()}
    text = f"use {library.stem}\n{_SCENE.format(name=thing.name, **numbers)}"
    task = _checked(text, library.parent / f"{thing.name}.thumbnail.wms")
    target = library.parent / THUMBNAILS / f"{thing.name}.png"
    target.parent.mkdir(exist_ok=True)
    task[0].run(engine).picture("front", 0.0, size=THUMBNAIL).save(target)
    return target


def _checked(text: str, path: Path) -> Task:
    check = TextCheck(text, path)
    errors = [d for d in check.diagnosis(tried=False).diagnostics if d.severity == "error"]
    if errors or not check.tasks:
        raise SpecError.of(errors)
    return check.tasks[0]


def _meshes(paths: Sequence[Path]) -> Iterator[Path]:
    count = 0
    for path in paths:
        if not path.exists():
            raise WmsError("there is no such file or folder", FilePlace(str(path)))
        found = sorted(p for p in path.rglob("*") if p.is_file() and _is_mesh(p)) if path.is_dir() else [path]
        if not found or not all(map(_is_mesh, found)):
            raise WmsError("is no mesh", FilePlace(str(path)), f"meshes end in {', '.join(FILES['file'])}")
        count += len(found)
        if count > MAX_THINGS:
            raise WmsError(f"more than {MAX_THINGS} meshes", FilePlace(str(path)), "add fewer at once")
        yield from found


def _is_mesh(path: Path) -> bool:
    return path.suffix.lower() in FILES["file"] and path.suffix.lower() not in ASSETS


def _relative(path: Path, home: Path) -> str:
    if not path.resolve().is_relative_to(home):
        raise WmsError(f"is not below {home}", FilePlace(str(path)), "copy it there, or choose the folder with --to")
    file = path.resolve().relative_to(home).as_posix()
    if '"' in file or "\\" in file:
        raise WmsError("a file with such a name cannot be used", FilePlace(str(path)), "rename it")
    return file


def _name(path: Path) -> str:
    """Return the identifier of a mesh: of its file, or of the nearest folder whose name is not generic."""
    candidates = (path.stem, *(parent.name for parent in path.resolve().parents))
    named = next((each for each in candidates if each and not _GENERIC.fullmatch(each.lower())), path.stem)
    return re.sub(r"_+", "_", to_identifier(re.sub(r"^\d+[_-]+(?=\D)", "", named)).lower()).strip("_") or "thing"


def _unique(name: str, taken: set[str]) -> str:
    return next(each for each in (name, *(f"{name}_{n}" for n in range(2, 10**6))) if each not in taken)


def _thing(path: Path, file: str, name: str, options: ThingOptions) -> Thing:
    import numpy as np
    import trimesh

    try:
        check_mesh_file(path)
        loaded: Any = trimesh.load(path, force="mesh", skip_materials=True)
        if not len(loaded.faces):
            raise WmsError("has no faces", help="export it again")
        extents, filled = np.asarray(loaded.extents, float), _convexity(loaded)
    except WmsError as error:
        raise WmsError(error.diagnostics[0].message, FilePlace(str(path)), error.diagnostics[0].help) from None
    except Exception as error:  # noqa: BLE001  readers of meshes raise anything
        raise WmsError(f"cannot be read ({type(error).__name__})", FilePlace(str(path)), "export it again") from None
    up = options.up or ("y" if path.suffix.lower() in Y_UP else "z")
    own = loaded.units if path.suffix.lower() == ".dae" and loaded.units in MESH_UNITS else "m"
    units = options.units or own
    x, y, z = (float(edge) * MESH_UNITS[units] for edge in extents)
    size = {"x": (y, z, x), "y": (x, z, y), "z": (x, y, z)}[up]
    if not MIN_SIZE <= max(size) <= MAX_SIZE:
        likely = [unit for unit, metres in MESH_UNITS.items() if 0.02 <= float(max(extents)) * metres <= 2]
        remedy = f"give its units, such as --units {likely[-1] if likely else 'mm'}"
        raise WmsError(f"is {max(size):.3g} m large if its lengths are in {units}", FilePlace(str(path)), remedy)
    way = options.collision if options.collision != "auto" else "hull" if filled >= MIN_CONVEXITY else "pieces"
    mass = (options.masses or {}).get(name)
    return Thing(
        name=name, file=file, units=units, up=up, collision=way, mass=mass, size=size,
        density=None if mass is not None else options.density, license=options.license, source=options.source,
    )  # fmt: skip


def _convexity(mesh: Any) -> float:
    """Return the share of its hull that a mesh fills; an open mesh counts as convex, as its volume is unknown."""
    return float(mesh.volume / mesh.convex_hull.volume) if mesh.is_watertight else 1.0


def _read(home: Path) -> _Record:
    path = home / RECORD
    if not path.exists():
        if (home / LIBRARY).exists():
            raise WmsError(f"is there without {RECORD}", FilePlace(str(home / LIBRARY)), "move it, or choose --to")
        return _Record()
    try:
        return _Record.model_validate_json(read_bytes(path, FILE_BYTES))
    except ValidationError as error:
        what = f"is no record of things: {error.errors()[0]['msg']}"
        raise WmsError(what, FilePlace(str(path)), "restore or remove it") from None


def _library(things: Sequence[Thing]) -> str:
    """Return the text of the library; its licences and sources go to the cards of datasets."""
    head = [f'"""Written by `wmspec things add` from {RECORD}; the next call replaces it."""']
    for key in ("license", "source"):
        values = list(dict.fromkeys(getattr(thing, key) for thing in things if getattr(thing, key)))
        if values:
            head.append(f'{key} "{"; ".join(sorted(values))}"')
    return "\n".join(head) + "\n\n" + "\n\n".join(thing.template for thing in things) + "\n"
