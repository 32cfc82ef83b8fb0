"""Names of prims in USD files: `thing.usda#/World/Cup`."""

from __future__ import annotations

import re

_NAMED = re.compile(r"(.*\.usd[acz]?)#(.*)", re.IGNORECASE | re.DOTALL)


def split_prim_name(name: str) -> tuple[str, str]:
    """Return the file and the prim path, which is '' if none is named."""
    match = _NAMED.fullmatch(name)
    return (match[1], match[2] or "/") if match else (name, "")
