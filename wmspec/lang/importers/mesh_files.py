"""Checks mesh files before they are loaded: size and references to other files.

The checks do not rely on those of the loading library.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from wmspec.core.diagnostics import WmsError
from wmspec.core.limits import FILE_BYTES, POINTS
from wmspec.core.safe_io import is_within, open_file, read_bytes

#: Size (bytes) of a face and of the header of a binary STL file.
_STL_FACE, _STL_HEAD = 50, 84
#: glTF extensions that store points in a form of their own.
_COMPRESSIONS = ("KHR_draco_mesh_compression", "EXT_meshopt_compression")


def check_mesh_file(path: Path) -> None:
    """Raise WmsError if a file is too large, has entities, or refers to files outside its folder."""
    size = path.stat().st_size
    kind = path.suffix.lower()
    if size > FILE_BYTES.most:
        raise FILE_BYTES.exceeded()
    if kind == ".stl" and (size - _STL_HEAD) / _STL_FACE * 3 > POINTS.most and _binary(path):
        raise POINTS.exceeded()
    if kind == ".dae" and b"<!" in read_bytes(path, FILE_BYTES).replace(b"<!--", b"").replace(b"<![CDATA[", b""):
        raise WmsError("has a DTD or entities, which are not allowed", help="remove them, or export it again")
    if kind in (".gltf", ".glb"):
        content = _gltf(path)
        _check_extensions(content)
        _check_references(path, content)


def _binary(path: Path) -> bool:
    with open_file(path) as file:
        return not file.read(6).lower().startswith(b"solid ")


def _gltf(path: Path) -> Any:
    """Return the JSON of a glTF file, or None if it is invalid, which its reader reports."""
    content = read_bytes(path, FILE_BYTES)
    if path.suffix.lower() == ".glb":
        if len(content) < 20:
            return None
        (length,) = struct.unpack_from("<I", content, 12)
        content = content[20 : 20 + length]
    try:
        return json.loads(content)
    except (ValueError, RecursionError):
        return None


def _check_extensions(content: Any) -> None:
    """Raise WmsError if the points cannot be read without an extension that decodes them."""
    required = content.get("extensionsRequired") if isinstance(content, dict) else None
    for name in required if isinstance(required, list) else ():
        if name in _COMPRESSIONS:
            raise WmsError(f"is compressed ({name}), which is not supported", help="export it without compression")


def _check_references(path: Path, content: Any) -> None:
    """Raise WmsError for a reference outside the file's folder, and for too many points."""
    for uri in _all(content, "uri"):
        if not uri.startswith("data:") and not is_within(path.parent, path.parent / uri):
            raise WmsError(f"uses `{uri[:80]}`, which is not beside it", help="put it there, or export a .glb")
    if sum(count for count in _all(content, "count") if count > 0) > 10 * POINTS.most:
        raise POINTS.exceeded()


def _all(content: Any, key: str) -> Iterator[Any]:
    """Yield the values of a key in all parts of a glTF: texts of `uri`, numbers of `count`."""
    for part in ("buffers", "images", "accessors"):
        for each in content.get(part, ()) if isinstance(content, dict) and isinstance(content.get(part), list) else ():
            value = each.get(key) if isinstance(each, dict) else None
            if isinstance(value, str if key == "uri" else int):
                yield value
