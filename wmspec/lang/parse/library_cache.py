"""Parsed libraries on disk: a library that parsed without mistakes is read back as its syntax tree."""

from __future__ import annotations

import gc
import io
import pickle
from typing import Any

from wmspec.core import disk_cache
from wmspec.core.node import Node
from wmspec.core.places import Source, Span
from wmspec.lang.parse import syntax


def kept(source: Source) -> syntax.File | None:
    """The syntax tree of a library as it was parsed before; None if this text was not, by this version of wmspec."""
    content = disk_cache.read(_entry(source))
    if content is None:
        return None
    collecting = gc.isenabled()
    gc.disable()  # nothing that is read becomes garbage
    try:
        tree = _Reader(source, content).load()
    except Exception:  # noqa: BLE001  whatever an entry holds that this version does not write, it is parsed anew
        return None
    finally:
        if collecting:
            gc.enable()
    return tree if isinstance(tree, syntax.File) else None


def keep(source: Source, tree: syntax.File) -> None:
    """Keep the syntax tree of a library for other processes."""
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
        """The text itself is not kept: whoever reads the tree has it."""
        return "source" if isinstance(made, Source) else None


class _Reader(pickle.Unpickler):
    """Knows the classes of the syntax tree only, so that no entry can call anything else."""

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
