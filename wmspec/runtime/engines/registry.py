"""The installed backends, by entry point. An engine is imported when it is first used and never before."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points, version
from typing import cast, get_args

from wmspec import __version__
from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.core.native_output import silence
from wmspec.sim.photo import library as photo
from wmspec.sim.scene.backend import Backend, Info
from wmspec.sim.scene.model import Look

GROUP = "wmspec.backends"


@cache
def _entries() -> dict[str, EntryPoint]:
    return {e.name: e for e in sorted(entry_points(group=GROUP), key=lambda e: e.name)}


#: Backends of this process alone.
_registered: dict[str, Backend] = {}


def register(backend_: Backend) -> None:
    """Have a backend in this process alone, as in a notebook; an entry point has it everywhere.

    It replaces one that was registered by the same name. Raises WmsError if an entry point has that name.
    """
    name = backend_.info.name
    if name in _entries():
        raise WmsError(f"there is a backend `{name}` already; choose another name")
    _registered[name] = backend_
    for known in (info, backend):
        known.cache_clear()


def only_here(engines: Iterable[str]) -> bool:
    """Whether one of the engines is unknown to other processes."""
    return not _registered.keys().isdisjoint(engines)


def names() -> tuple[str, ...]:
    """The names of all backends that wmspec knows, whether or not their engine is installed."""
    return (*_entries(), *_registered)


@cache
def info(name: str) -> Info:
    """What the backend of that name says of itself, whether or not its engine is installed.

    Raises WmsError if there is none.
    """
    return _loaded(name).info


@cache
def backend(name: str) -> Backend:
    """The backend of that name. Raises WmsError if there is none, or if its engine is not installed."""
    engine = _loaded(name)
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
            f"the engine of backend `{name}` fails as it is imported ({error}); `wmspec doctor` tells what mends it"
        ) from None
    return engine


def _loaded(name: str) -> Backend:
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
    """The backend where none is named: the first of wmspec's own, or else of others, whose engine can be imported."""
    known = sorted(_entries().values(), key=lambda e: (e.dist is None or e.dist.name != "wmspec", e.name))
    return next((e.name for e in known if _works(e.name)), "") or _none()[0]


def chosen(choice: str) -> tuple[str, ...]:
    """The backends meant by `--backend`: names joined by commas, or `all` for those whose engine can be imported.

    The default one, if none is named. Raises WmsError for one that there is not.
    """
    if choice != "all":
        wanted = tuple(dict.fromkeys(n.strip() for n in choice.split(",") if n.strip()))
        for name in wanted:
            backend(name)
        return wanted or (default(),)
    return tuple(name for name in names() if _works(name)) or _none()


def drawing(engines: Sequence[str], look: Look) -> tuple[str, ...]:
    """The engines, if all of them can draw the look. Raises WmsError with those that can.

    Mitsuba draws the look "photo"; its masks and distances are those of the engine's parity look.
    """
    if look not in get_args(Look):
        raise WmsError(f"no look `{look}`; choose `parity`, the same picture from every engine, or `photo`, for people")
    if look == "photo":
        photo.mitsuba()
    for name in engines:
        if not info(name).draws:
            able = ", ".join(other for other in names() if _works(other) and info(other).draws)
            raise WmsError(
                f"{name} cannot draw; choose among {able or 'engines yet to be installed'} with "
                "--backend, or in `wmspec render` with --renderer"
            )
    return tuple(engines)


def engine_version(name: str) -> str:
    """The version of the backend's engine, as its package says."""
    return version(info(name).distribution)


def versions(engines: Iterable[str], look: Look) -> dict[str, str]:
    """The versions that decide a dataset's bytes: of wmspec, of engines, and of what draws the look "photo"."""
    return {name: version_of(name) for name in ("wmspec", *engines, *(photo.DISTRIBUTIONS if look == "photo" else ()))}


def version_of(name: str) -> str:
    """The version of one of them."""
    if name == "wmspec":
        return __version__
    return photo.versions()[name] if name in photo.DISTRIBUTIONS else engine_version(name)


def _works(name: str) -> bool:
    try:
        backend(name)
    except WmsError:
        return False
    return True


def _none() -> tuple[str, ...]:
    requirements = " or ".join(f"`pip install '{info(name).requirement}'`" for name in names())
    raise WmsError(f"no engine is installed; try {requirements}, and `wmspec doctor` for the rest")
