"""A digest of the installed code that results depend on: equal on all machines with the same files."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from functools import cache
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path

from wmspec.core.resources import resource

#: The folders that compile, execute and measure. Others present results, or store them.
FOLDERS = ("core", "sim", "lang", "compile", "runtime", "backends", "grammar")
#: Distributions that compute.
DISTRIBUTIONS = ("numpy", "scipy", "trimesh", "usd-core", "lark", "coacd")


@cache
def code_digest() -> str:
    """Return the digest of the files of wmspec that results depend on, and of the versions of other packages."""
    made = hashlib.sha256()
    for name in FOLDERS:
        _add(made, resource(name))
    for name in DISTRIBUTIONS:
        made.update(f"{name} {installed_version(name)}\0".encode())
    return made.hexdigest()


@cache
def package_digest(module: str) -> str:
    """Return the digest of the Python files of a module or package, without importing it."""
    made = hashlib.sha256()
    spec = find_spec(module)
    if spec is not None:
        for place in spec.submodule_search_locations or [spec.origin or ""]:
            _add(made, Path(place), ".py")
    return made.hexdigest()


def _add(made: hashlib._Hash, place: Path, suffix: str = "") -> None:
    for path in sorted(_files(place)):
        if path.suffix == suffix or not suffix:
            content = path.read_bytes()
            made.update(f"{path.relative_to(place.parent).as_posix()} {len(content)}\0".encode())
            made.update(content)


def _files(place: Path) -> Iterator[Path]:
    if place.is_file():
        yield place
    elif place.is_dir() and place.name != "__pycache__":
        for path in place.iterdir():
            yield from _files(path)


def installed_version(distribution: str) -> str:
    """Return the version of a distribution; empty if it is not installed."""
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return ""
