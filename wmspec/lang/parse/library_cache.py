"""Disk cache of parsed libraries: a library without syntax errors is restored as its syntax tree."""

from __future__ import annotations

import gc
import io
import pickle
from typing import Any

from wmspec.core import disk_cache
from wmspec.core.node import Node
from wmspec.core.places import Source, Span
from wmspec.lang.parse import syntax


def load_cached(source: Source) -> syntax.File | None:
    """Return the cached syntax tree of a library, or None if this version of wmspec has not parsed this text."""
    content = disk_cache.read(_entry(source))
    if content is None:
        return None
    collecting = gc.isenabled()
    gc.disable()  # unpickling creates no garbage
    try:
        tree = _Reader(source, content).load()
    except Exception:  # noqa: BLE001  an invalid entry is parsed again
        return None
    finally:
        if collecting:
            gc.enable()
    return tree if isinstance(tree, syntax.File) else None


def store(source: Source, tree: syntax.File) -> None:
    """Store the syntax tree of a library for other processes."""
    made = io.BytesIO()
    _Writer(made).dump(tree)
    disk_cache.write(_entry(source), made.getvalue())


def _entry(source: Source) -> str:
    key = "\0".join((disk_cache.fingerprint(), source.name, source.text))
    return f"library-{disk_cache.digest(key.encode('utf-8', 'surrogatepass'))[:32]}"


class _Writer(pickle.Pickler):
    def __init__(self, file: io.BytesIO) -> None:
        super().__init__(file, protocol=5)

    def persistent_id(self, made: object) -> str | None:
        """Replace the text itself by a reference: the reader of the cache has it."""
        return "source" if isinstance(made, Source) else None


class _Reader(pickle.Unpickler):
    """Unpickler restricted to the classes of the syntax tree, so that no entry can call other code."""

    def __init__(self, source: Source, content: bytes) -> None:
        super().__init__(io.BytesIO(content))
        self._source = source

    def find_class(self, module: str, name: str) -> Any:
        found = Span if (module, name) == (Span.__module__, "Span") else vars(syntax).get(name)
        if isinstance(found, type) and found.__module__ == module and issubclass(found, Node | Span):
            return found
        raise pickle.UnpicklingError(f"{module}.{name} is no part of a syntax tree")

    def persistent_load(self, _: str) -> Source:
        return self._source
