"""Which of the libraries that come with wmspec declares a name, for whoever forgot to `use` it."""

from __future__ import annotations

import re
from collections.abc import Collection
from functools import cache

from wmspec.lang.parse.files import library_folder

#: Those with a place for things and cameras around it: they go before the others.
_PLACES = ("tabletop", "room")
_DECLARED = re.compile(r"^(?:object|template|camera)\s+(\w+)", re.MULTILINE)
#: What is used as it is: with `only` or `as` it brings other names.
_USED = re.compile(r"^use (\w+)(?:\([^)\n]*\))?$", re.MULTILINE)


def having(names: Collection[str]) -> tuple[str, frozenset[str]]:
    """The library that declares most of the names, and all that it declares; an empty name if none has any."""
    wanted = frozenset(names)
    best = max(_libraries(), key=lambda library: len(wanted & _declared(library)), default="")
    return (best, _declared(best)) if best and wanted & _declared(best) else ("", frozenset())


@cache
def _libraries() -> tuple[str, ...]:
    there = sorted(path.stem for path in library_folder().glob("*.wms"))
    return (*(name for name in _PLACES if name in there), *(name for name in there if name not in _PLACES))


@cache
def _declared(library: str) -> frozenset[str]:
    text = (library_folder() / f"{library}.wms").read_text(encoding="utf-8")
    return frozenset(_DECLARED.findall(text)).union(*map(_declared, _USED.findall(text)))
