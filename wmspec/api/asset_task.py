"""A task of one asset or mesh file: it is let go on a ground."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

from wmspec.api.loading import Tell, TextCheck, warn, without_approximations
from wmspec.api.task import Task
from wmspec.core.diagnostics import Diagnostic, SpecError, WmsError
from wmspec.core.limits import FILE_BYTES
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import read_bytes
from wmspec.lang.check.tables.vocabulary import ASSETS, FILES, STAGES
from wmspec.lang.importers.blocks import to_identifier

#: Extensions of files that are run without a spec; stages are run as they are.
RUN_FILES = tuple(ending for ending in (*ASSETS, *FILES["file"]) if ending not in STAGES)

_SPEC = """task run : custom {{
{ground}  object {name} {{ file: "{file}"  {place} }}
  horizon {seconds} s
  camera front {{ at: (2 m, -3 m, 1.5 m)  look_at: (0, 0, 40 cm) }}
  observe front at [0 s]
}}
"""
_GROUND = (
    "  object floor_ {{ shape: box  size: (40 m, 40 m, 10 cm)  at: (0, 0, {:.9g} m)  fixed: true  color: mist }}\n"
)
_PLANE = re.compile(rb"""<geom\b[^>]*\btype\s*=\s*["']plane["'][^>]*>""")
_PLACE = re.compile(rb"""\bpos\s*=\s*["']\s*\S+\s+\S+\s+([-+.\deE]+)\s*["']""")
_DEFAULT_SECONDS = 2.0
#: Codes of what is wrong with the file, with the generated scene, and with the size of a mesh.
_FILE, _SCENE, _SIZE = "WMS2", "WMS6", "WMS606"


def asset_task(path: Path, seconds: float | None = None, *, strict: bool = False, tell: Tell = warn) -> Task:
    """Return the task of a URDF, MJCF or mesh file, lasting 2 s or `seconds`.

    The file stands on a ground. MJCF keeps its own place, on a ground at the height of its first plane. Its meshes lie
    below the current folder if the file does, else below the folder of the file. Warnings go to `tell`. Raises WmsError
    if the file cannot be read, or, if `strict`, not exactly.
    """
    if not path.is_file():
        raise WmsError("there is no such file", FilePlace(str(path)))
    whole = path.resolve()
    folder = Path.cwd() if whole.is_relative_to(Path.cwd()) else whole.parent
    file = whole.relative_to(folder).as_posix()
    if '"' in file or "\\" in file:
        raise WmsError("a file with such a name cannot be run", FilePlace(str(path)), "rename it")
    native = path.suffix.lower() == ".xml"
    height = plane_height(read_bytes(path, FILE_BYTES)) if native else 0.0
    name = to_identifier(path.stem) or "it"
    text = _SPEC.format(
        ground="" if height is None else _GROUND.format(height - 0.05),
        name=f"{name}_" if name in ("floor_", "front", "end", "index") else name,
        file=file,
        place="at: (0, 0, 0)" if native else "on: floor_ at (0, 0)",
        seconds=f"{seconds or _DEFAULT_SECONDS:.9g}",
    )
    check = TextCheck(text, folder / f"{path.stem}.wms")
    tried = check.diagnosis(tried=path.suffix.lower() in FILES["file"]).diagnostics
    found = tuple(d for d in tried if not d.code.startswith(_SCENE) or d.code == _SIZE)
    found = without_approximations(found) if strict else found
    if not check.tasks or any(d.severity == "error" for d in found):
        raise SpecError.of(_about_file(d, path) for d in found if d.severity == "error")
    for diagnostic in found:
        if diagnostic.code.startswith(_FILE) or diagnostic.code == _SIZE:
            tell(_about_file(diagnostic, path).render())
    return check.tasks[0]


def plane_height(mjcf: bytes) -> float | None:
    """Return the height (m) of the first plane of an MJCF, or None if it has none."""
    plane = _PLANE.search(mjcf)
    place = _PLACE.search(plane[0]) if plane else None
    try:
        return None if plane is None else float(place[1]) if place else 0.0
    except ValueError:  # MuJoCo reports it
        return 0.0


def _about_file(diagnostic: Diagnostic, path: Path) -> Diagnostic:
    """Return a diagnostic without its place in the generated text, and without a spec's folder."""
    place = None if path.name in diagnostic.message else FilePlace(str(path))
    if (below := "below the spec's folder") in diagnostic.message:
        message = diagnostic.message.replace(below, "below the current folder or that of the file")
        return replace(diagnostic, message=message, place=place, notes=(), help="run wmspec in a folder above both")
    return replace(diagnostic, place=place, notes=())
