"""Installed backends, by entry point. An engine is imported on first use."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points, version
from typing import cast, get_args

from wmspec import __version__
from wmspec.core.code_digest import package_digest
from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.core.native_output import silence
from wmspec.sim.photo import library as photo
from wmspec.sim.scene.backend import Backend, Info
from wmspec.sim.scene.model import Look

GROUP = "wmspec.backends"


@cache
def _entries() -> dict[str, EntryPoint]:
    return {e.name: e for e in sorted(entry_points(group=GROUP), key=lambda e: e.name)}


#: Backends registered in this process only.
_registered: dict[str, Backend] = {}


def register(backend_: Backend) -> None:
    """Register a backend in this process only, as in a notebook; an entry point registers it everywhere.

    It replaces a registered backend of the same name. Raises WmsError if an entry point has that name.
    """
    name = backend_.info.name
    if name in _entries():
        raise WmsError(f"there is a backend `{name}` already; choose another name")
    _registered[name] = backend_
    for known in (info, backend):
        known.cache_clear()


def is_process_local(engines: Iterable[str]) -> bool:
    """Whether one of the engines is registered in this process only."""
    return not _registered.keys().isdisjoint(engines)


def names() -> tuple[str, ...]:
    """Return the names of all backends, with or without an installed engine."""
    return (*_entries(), *_registered)


@cache
def info(name: str) -> Info:
    """Return the description of a backend, with or without an installed engine.

    Raises WmsError if there is no such backend.
    """
    return _load_backend(name).info


@cache
def backend(name: str) -> Backend:
    """Return a backend. Raises WmsError if there is none with that name, or if its engine is not installed."""
    engine = _load_backend(name)
    try:
        with silence():
            import_module(engine.info.module)
    except ImportError as error:
        raise WmsError(
            f"the engine of backend `{name}` cannot be imported ({error}); "
            f"install it with `pip install '{engine.info.requirement}'`"
        ) from None
    except Exception as error:  # noqa: BLE001  whatever an engine does while it is imported
        raise WmsError(
            f"the engine of backend `{name}` fails as it is imported ({error}); `wmspec doctor` names the remedy"
        ) from None
    return engine


def _load_backend(name: str) -> Backend:
    entries = _entries()
    if name in _registered:
        return _registered[name]
    if name not in entries:
        raise WmsError(f"there is no backend `{name}`; {suggestion(name, names()) or 'none is installed'}")
    try:
        return cast(Backend, entries[name].load())
    except Exception as error:
        kind = "" if isinstance(error, ImportError) else f"{type(error).__name__}: "
        raise WmsError(
            f"the backend `{name}` cannot be loaded ({kind}{error}); install again what brings it"
        ) from error


def default() -> str:
    """Return the default backend: the first with an importable engine, those of wmspec before others."""
    return next((name for name in _by_origin(_entries()) if _is_importable(name)), "") or _none()[0]


def _by_origin(names: Iterable[str]) -> list[str]:
    """Return backends in order: those of wmspec before others, so that these do not become the reference engine."""
    entries = _entries()

    def foreign(name: str) -> bool:
        entry = entries.get(name)
        return entry is None or entry.dist is None or entry.dist.name != "wmspec"

    return sorted(names, key=foreign)  # stable: `names` come sorted


def select_backends(choice: str) -> tuple[str, ...]:
    """Return the backends of a `--backend` option: names joined by commas, or `all` with importable engines.

    An empty option selects the default. Raises WmsError for unknown backends.
    """
    if choice != "all":
        chosen = tuple(dict.fromkeys(n.strip() for n in choice.split(",") if n.strip()))
        for name in chosen:
            backend(name)
        return chosen or (default(),)
    return tuple(name for name in _by_origin(names()) if _is_importable(name)) or _none()


def quickest_renderer(engines: Sequence[str]) -> str:
    """Return the engine that draws in the least time; the first engine if none draws, so that the error names it."""
    able = [name for name in engines if info(name).draws]
    return min(able or engines[:1], key=lambda name: info(name).drawing_cost)


def require_look(engines: Sequence[str], look: Look) -> tuple[str, ...]:
    """Return the engines if all of them can render the look. Raises WmsError that names those that can.

    Mitsuba renders the look "photo"; its masks and depth maps are those of the engine's parity look.
    """
    if look not in get_args(Look):
        raise WmsError(f"no look `{look}`; choose `parity`, the same picture from every engine, or `photo`, for people")
    if look == "photo":
        photo.mitsuba()
    for name in engines:
        if not info(name).draws:
            able = ", ".join(other for other in names() if _is_importable(other) and info(other).draws)
            raise WmsError(
                f"{name} cannot draw; choose among {able or 'engines yet to be installed'} with "
                "--backend, or in `wmspec render` with --renderer"
            )
    return tuple(engines)


def engine_version(name: str) -> str:
    """Return the version of the backend's engine package."""
    return version(info(name).distribution)


def backend_digest(name: str) -> str:
    """Return the digest of a backend's code; '' for one of wmspec, whose code `code_digest` has."""
    entry = _entries().get(name)
    if entry is None or (entry.dist is not None and entry.dist.name == "wmspec"):
        return ""
    return package_digest(entry.module)


def versions(engines: Iterable[str], look: Look) -> dict[str, str]:
    """Return the versions that determine a dataset's bytes: wmspec, engines, and the renderer of "photo"."""
    return {name: version_of(name) for name in ("wmspec", *engines, *(photo.DISTRIBUTIONS if look == "photo" else ()))}


def version_of(name: str) -> str:
    """Return the version of one of them."""
    if name == "wmspec":
        return __version__
    return photo.versions()[name] if name in photo.DISTRIBUTIONS else engine_version(name)


def _is_importable(name: str) -> bool:
    try:
        backend(name)
    except WmsError:
        return False
    return True


def _none() -> tuple[str, ...]:
    requirements = " or ".join(f"`pip install '{info(name).requirement}'`" for name in names())
    raise WmsError(f"no engine is installed; try {requirements}, and `wmspec doctor` for the rest")
