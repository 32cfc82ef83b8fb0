"""Files of meshes looked at before they are read: how much they hold, and that they name no other files.

The library that reads them, and those that it uses, may refuse the same, or may cease to.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from wmspec.core.diagnostics import WmsError
from wmspec.core.limits import BYTES, POINTS
from wmspec.core.safe_io import inside

#: A face of a binary STL file takes so many bytes, after so many of its head.
_STL_FACE, _STL_HEAD = 50, 84


def harmless(path: Path) -> None:
    """Raise WmsError if a file is too large, or names what it must not: entities, or files that are not beside it."""
    size = path.stat().st_size
    kind = path.suffix.lower()
    if size > BYTES.most:
        raise BYTES.exceeded()
    if kind == ".stl" and (size - _STL_HEAD) / _STL_FACE * 3 > POINTS.most and _binary(path):
        raise POINTS.exceeded()
    if kind == ".dae" and b"<!" in path.read_bytes().replace(b"<!--", b"").replace(b"<![CDATA[", b""):
        raise WmsError("has a document type or entities", help="remove them, or export it again")
    if kind in (".gltf", ".glb"):
        _referring(path, _gltf(path))


def _binary(path: Path) -> bool:
    with path.open("rb") as file:
        return not file.read(6).lower().startswith(b"solid ")


def _gltf(path: Path) -> Any:
    """What a glTF file says, in JSON; None if it is no such file, which its reader tells."""
    content = path.read_bytes()
    if path.suffix.lower() == ".glb":
        if len(content) < 20:
            return None
        (length,) = struct.unpack_from("<I", content, 12)
        content = content[20 : 20 + length]
    try:
        return json.loads(content)
    except (ValueError, RecursionError):
        return None


def _referring(path: Path, told: Any) -> None:
    """Raise WmsError for a file that is not beside this one, and for more points than are read."""
    for uri in _all(told, "uri"):
        if not uri.startswith("data:") and not inside(path.parent, path.parent / uri):
            raise WmsError(f"uses `{uri[:80]}`, which is not beside it", help="put it there, or export a .glb")
    if sum(count for count in _all(told, "count") if count > 0) > 10 * POINTS.most:
        raise POINTS.exceeded()


def _all(told: Any, key: str) -> Iterator[Any]:
    """The values of a key that the parts of a glTF have: texts of `uri`, numbers of `count`."""
    for part in ("buffers", "images", "accessors"):
        for each in told.get(part, ()) if isinstance(told, dict) and isinstance(told.get(part), list) else ():
            value = each.get(key) if isinstance(each, dict) else None
            if isinstance(value, str if key == "uri" else int):
                yield value
