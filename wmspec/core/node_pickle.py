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
    _Writer(file).dump(made)
    return file.getvalue()


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


class _Writer(pickle.Pickler):
    def __init__(self, file: io.BytesIO) -> None:
        super().__init__(file, protocol=5)

    def persistent_id(self, made: object) -> str | None:
        """Replace the text itself by a reference: the reader of the cache has it."""
        return "source" if isinstance(made, Source) else None


class _Reader(pickle.Unpickler):
    def __init__(self, content: bytes, module: ModuleType, source: Source | None) -> None:
        super().__init__(io.BytesIO(content))
        self._modules = {each.__name__: each for each in (module, places)}
        self._source = source

    def find_class(self, module: str, name: str) -> Any:
        found = vars(self._modules[module]).get(name) if module in self._modules else None
        if isinstance(found, type) and found.__module__ == module and issubclass(found, Node | Span):
            return found
        raise pickle.UnpicklingError(f"{module}.{name} is no node")

    def persistent_load(self, _: str) -> Source:
        if self._source is None:
            raise pickle.UnpicklingError("there is no source text")
        return self._source
