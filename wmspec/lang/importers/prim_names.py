"""A prim in a USD file, as a file name of the language: `thing.usda#/World/Cup`."""

from __future__ import annotations

import re

_NAMED = re.compile(r"(.*\.usd[acz]?)#(.*)", re.IGNORECASE | re.DOTALL)


def parted(name: str) -> tuple[str, str]:
    """The file and the path of the prim, which is empty if none is named."""
    match = _NAMED.fullmatch(name)
    return (match[1], match[2] or "/") if match else (name, "")
