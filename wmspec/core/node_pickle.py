"""Nodes as bytes, for caches: pickles that can hold nodes alone, so that not even a forged one executes code."""

from __future__ import annotations

import gc
import io
import pickle
from types import ModuleType
from typing import Any

from wmspec.core import places
from wmspec.core.node import Node
from wmspec.core.places import Source, Span


def dumps(made: object) -> bytes:
    """Return nodes, and tuples and dictionaries of them, as bytes; a source text becomes a reference."""
    file = io.BytesIO()
    writer = pickle.Pickler(file, protocol=5)
    writer.dispatch_table = {Source: lambda _: (_reference, ())}
    writer.dump(made)
    return file.getvalue()


def _reference() -> Source:
    """Refer to the source text, which the reader of the cache has; `_Reader` replaces this function."""
    raise NotImplementedError


def loads(content: bytes, module: ModuleType, source: Source | None = None) -> Any:
    """Return what `dumps` was given, with the classes of a module; references become `source`.

    Raises ValueError if the bytes hold anything else.
    """
    collecting = gc.isenabled()
    gc.disable()  # unpickling creates no garbage
    try:
        return _Reader(content, module, source).load()
    except Exception as error:  # noqa: BLE001  damaged pickles raise anything
        raise ValueError(f"these bytes hold no nodes: {error}") from None
    finally:
        if collecting:
            gc.enable()


class _Reader(pickle.Unpickler):
    def __init__(self, content: bytes, module: ModuleType, source: Source | None) -> None:
        super().__init__(io.BytesIO(content))
        self._modules = {each.__name__: each for each in (module, places)}
        self._source = source

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) == (__name__, _reference.__name__):
            return self._given_source
        found = vars(self._modules[module]).get(name) if module in self._modules else None
        if isinstance(found, type) and found.__module__ == module and issubclass(found, Node | Span):
            return found
        raise pickle.UnpicklingError(f"{module}.{name} is no node")

    def _given_source(self) -> Source:
        if self._source is None:
            raise pickle.UnpicklingError("there is no source text")
        return self._source
