"""USD files opened: within bounds, in silence, all of their layers below the spec's folder."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path

from pxr import Usd, UsdUtils

from wmspec.importers.model import Broken, Faults
from wmspec.importers.usd_prims import Prims

#: The largest file, bytes.
MOST_BYTES = 100_000_000


@contextmanager
def opened(path: Path, folder: Path | None, shown: str, faults: Faults) -> Iterator[Prims]:
    """The prims of a USD file, all of whose layers are below a folder, if one is given.

    Raises Broken if it cannot be read, or whatever is done with it meanwhile goes wrong.
    """
    quiet = UsdUtils.CoalescingDiagnosticDelegate()  # what USD would print is told by us
    try:
        found = path.stat()
        if found.st_size > MOST_BYTES:
            raise faults.stop(shown, f"is larger than {MOST_BYTES // 1_000_000} MB", "is this the right file?")
        stage = _stage(str(path), found.st_mtime_ns, found.st_size)
        _whole(stage, folder, shown, faults)
        yield Prims(stage, shown, faults, folder)
    except Broken:
        raise
    except Exception as error:  # noqa: BLE001  what others wrote may be of any type
        what = complaint(error, path, path.name)
        raise faults.stop(shown, f"cannot be read: {what}", "mend it, or export it again") from None
    finally:
        del quiet


@lru_cache(maxsize=1)
def _stage(path: str, _changed: int, _size: int) -> Usd.Stage:
    """The stage in a file. The last one is kept: its meshes are asked for one by one."""
    stage = Usd.Stage.Open(path)
    stage.Reload()  # of a layer that was read before, USD gives what was in it then
    return stage


def _whole(stage: Usd.Stage, folder: Path | None, shown: str, faults: Faults) -> None:
    """Complain about what a stage is made of and is missing, or elsewhere."""
    for wrong in stage.GetCompositionErrors()[:1]:
        what = " ".join(str(wrong).split())
        if folder is not None:
            what = what.replace(str(folder.resolve()) + "/", "")
        raise faults.stop(shown, f"cannot be composed: {what[:160]}", "mend its references")
    for layer in stage.GetUsedLayers():
        beside = folder is None or layer.anonymous or Path(layer.realPath).resolve().is_relative_to(folder.resolve())
        if not beside:
            what = f"uses `{Path(layer.identifier).name}`, which is not below the spec's folder"
            raise faults.stop(shown, what, "put it beside the asset")


def complaint(error: Exception, path: Path, shown: str) -> str:
    """The first thing that pxr complains about a file, told as `shown`, without where in its own source."""
    said = str(error).partition(" : '")[2].partition("'\n")[0] or str(error) or type(error).__name__
    for name in (f"<{path.resolve()}>", str(path.resolve())):
        said = said.replace(name, shown)
    return " ".join(said.replace("</", "<").split())[: 120 + len(shown)]
