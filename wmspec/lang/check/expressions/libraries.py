"""Finds the bundled library that declares a name, to suggest a missing `use`."""

from __future__ import annotations

import re
from collections.abc import Collection
from functools import cache

from wmspec.lang.parse.files import library_folder

#: Libraries with a support for objects and cameras around it: suggested first.
_PREFERRED = ("tabletop", "room")
_DECLARED = re.compile(r"^(?:object|template|camera)\s+(\w+)", re.MULTILINE)
#: Plain `use` statements; `only` and `as` change the names.
_USED = re.compile(r"^use (\w+)(?:\([^)\n]*\))?$", re.MULTILINE)


def library_declaring(names: Collection[str]) -> tuple[str, frozenset[str]]:
    """Return the library that declares most of the names, and all its names; an empty name if none has any."""
    expected = frozenset(names)
    best = max(_libraries(), key=lambda library: len(expected & _declared(library)), default="")
    return (best, _declared(best)) if best and expected & _declared(best) else ("", frozenset())


@cache
def _libraries() -> tuple[str, ...]:
    there = sorted(path.stem for path in library_folder().glob("*.wms"))
    return (*(name for name in _PREFERRED if name in there), *(name for name in there if name not in _PREFERRED))


@cache
def _declared(library: str) -> frozenset[str]:
    text = (library_folder() / f"{library}.wms").read_text(encoding="utf-8")
    return frozenset(_DECLARED.findall(text)).union(*map(_declared, _USED.findall(text)))
