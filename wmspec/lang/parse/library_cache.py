"""Disk cache of parsed libraries: a library without syntax errors is restored as its syntax tree."""

from __future__ import annotations

from wmspec.core import disk_cache, node_pickle
from wmspec.core.places import Source
from wmspec.lang.parse import syntax


def load_cached(source: Source) -> syntax.File | None:
    """Return the cached syntax tree of a library, or None if this version of wmspec has not parsed this text."""
    content = disk_cache.read(_entry(source))
    if content is None:
        return None
    try:
        tree = node_pickle.loads(content, syntax, source)
    except ValueError:  # parsed again
        return None
    return tree if isinstance(tree, syntax.File) else None


def store(source: Source, tree: syntax.File) -> None:
    """Store the syntax tree of a library for other processes."""
    disk_cache.write(_entry(source), node_pickle.dumps(tree))


def _entry(source: Source) -> str:
    key = "\0".join((disk_cache.fingerprint(), source.name, source.text))
    return f"library-{disk_cache.digest(key.encode('utf-8', 'surrogatepass'))[:32]}"
