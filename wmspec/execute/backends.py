"""The installed backends, by entry point. An engine is imported when it is first used and never before."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from importlib.metadata import EntryPoint, entry_points, version
from typing import cast

from wmspec.diagnostics import WmsError, suggestion
from wmspec.scene.model import Backend, Look

GROUP = "wmspec.backends"


@cache
def _entries() -> dict[str, EntryPoint]:
    return {e.name: e for e in sorted(entry_points(group=GROUP), key=lambda e: e.name)}


def names() -> tuple[str, ...]:
    """The names of all backends that wmspec knows, whether or not their engine is installed."""
    return tuple(_entries())


@cache
def backend(name: str) -> Backend:
    """The backend of that name. Raises WmsError if there is none, or if its engine is not installed."""
    entries = _entries()
    if name not in entries:
        raise WmsError(f"there is no backend `{name}`; {suggestion(name, entries) or 'none is installed'}")
    try:
        return cast(Backend, entries[name].load())
    except ImportError as error:
        raise WmsError(
            f"the engine of backend `{name}` cannot be imported ({error}); "
            f"install it with `pip install 'wmspec[{name}]'`"
        ) from None
    except Exception as error:  # noqa: BLE001  whatever an engine does while it is imported
        raise WmsError(
            f"the engine of backend `{name}` fails as it is imported ({error}); `wmspec doctor` tells what mends it"
        ) from None


def chosen(choice: str) -> tuple[str, ...]:
    """The backends meant by `--backend`: names joined by commas, or `all` for those whose engine can be imported."""
    if choice != "all":
        wanted = tuple(dict.fromkeys(n.strip() for n in choice.split(",") if n.strip()))
        for name in wanted:
            backend(name)
        return wanted or _none()
    return tuple(name for name in names() if _works(name)) or _none()


def drawing(engines: Sequence[str], look: Look) -> tuple[str, ...]:
    """The engines, if all of them can draw the look. Raises WmsError with those that can."""
    for name in engines:
        if look not in backend(name).looks:
            able = ", ".join(other for other in names() if _works(other) and look in backend(other).looks)
            raise WmsError(
                f"{name} cannot draw the look `{look}`; choose among {able or 'engines yet to be installed'} with "
                "--backend, or in `wmspec render` with --renderer"
            )
    return tuple(engines)


def engine_version(name: str) -> str:
    """The version of the backend's engine, as its package says."""
    return version({"mujoco": "mujoco", "pybullet": "pybullet", "sapien": "sapien"}.get(name, name))


def _works(name: str) -> bool:
    try:
        backend(name)
    except WmsError:
        return False
    return True


def _none() -> tuple[str, ...]:
    raise WmsError("no engine is installed; try `pip install 'wmspec[mujoco]'`, and `wmspec doctor` for the rest")
