"""USD files of others, opened within bounds, in silence, all of their layers below the spec's folder."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path

from pxr import Sdf, Usd, UsdUtils

from wmspec.core.diagnostics import Diagnostic, Report, StageError, suggestion
from wmspec.core.limits import POINTS, PRIMS, TooLarge
from wmspec.core.places import FilePlace
from wmspec.lang.importers.model import Broken, Faults
from wmspec.sim.shapes import Mesh
from wmspec.sim.usd import meshes
from wmspec.sim.usd.files import opened, text_of
from wmspec.sim.usd.frames import World, split
from wmspec.sim.usd.prims import refuse, value
from wmspec.sim.usd.unsupported import incomplete

#: What stands behind the path of a mesh for those of its faces that are in no subset.
REST = ".rest"


@contextmanager
def stage_of(path: Path, folder: Path | None, shown: str, faults: Faults) -> Iterator[Usd.Stage]:
    """The stage in a USD file that messages call `shown`, all of whose layers are below a folder, if one is given.

    Raises Broken if it cannot be read, or whatever is done with it meanwhile goes wrong.
    """
    quiet = UsdUtils.CoalescingDiagnosticDelegate()  # what USD would print is told by us
    try:
        stat = path.stat()
        stage = _stage(str(path), stat.st_mtime_ns, stat.st_size)
        _whole(stage, folder, shown, faults)
        yield stage
    except Broken:
        raise
    except TooLarge as error:
        limit = error.diagnostics[0]
        raise faults.stop(FilePlace(shown), limit.message, limit.help) from None
    except Exception as error:  # noqa: BLE001  what others wrote may be of any type
        raise faults.stop(
            FilePlace(shown), f"cannot be read: {text_of(error)}", "mend it, or export it again"
        ) from None
    finally:
        del quiet


@lru_cache(maxsize=1)
def _stage(path: str, _changed: int, _size: int) -> Usd.Stage:
    """The stage in a file. The last one is kept: its meshes are asked for one by one."""
    return opened(Path(path), Path(path).name)


def _whole(stage: Usd.Stage, folder: Path | None, shown: str, faults: Faults) -> None:
    """Complain about what a stage is made of and is missing, or elsewhere, and about too much."""
    problems = Report(StageError)
    incomplete(stage, problems)
    note(problems.diagnostics, shown, faults, folder)
    if faults.diagnostics:
        raise Broken
    for layer in stage.GetUsedLayers():
        beside = folder is None or layer.anonymous or Path(layer.realPath).resolve().is_relative_to(folder.resolve())
        if not beside:
            what = f"uses `{Path(layer.identifier).name}`, which is not below the spec's folder"
            raise faults.stop(FilePlace(shown), what, "put it beside the asset")
    every = Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies())
    if any(count > PRIMS.most for count, _ in enumerate(every)):
        raise faults.stop(FilePlace(shown), PRIMS.sentence, PRIMS.help)


def note(problems: Iterable[Diagnostic], shown: str, faults: Faults, folder: Path | None = None) -> None:
    """Take note of what is wrong with prims of the file."""
    home = f"{folder.resolve()}/" if folder is not None else ""
    for problem in problems:
        reason = problem.message.replace(home, "") if home else problem.message
        faults.add(FilePlace(shown, element=f"`{problem.place}`"), reason[:300], problem.help)


def bounded(prim: Usd.Prim) -> None:
    """Refuse a mesh that is too large. Raises StageError."""
    if max(len(value(prim, name, ())) for name in ("points", "faceVertexIndices")) > POINTS.most:
        refuse(prim, f"it {POINTS.sentence}", POINTS.help)


def mesh(path: Path, folder: Path | None, shown: str, prim: str) -> Mesh | tuple[Diagnostic, ...]:
    """The mesh at a prim of a USD file, or the polygons of a GeomSubset; or else all that is wrong with it.

    It is seen from the prim's rigid frame: what the transforms to it scale, mirror or skew is in its points. `shown` is
    what the file is called, and all its layers are below `folder`, if one is given.
    """
    faults, problems = Faults(), Report(StageError)
    made: Mesh | None = None
    try:
        with stage_of(path, folder, shown, faults) as stage:
            named = prim.removesuffix(REST)
            at = stage.GetPrimAtPath(named) if Sdf.Path.IsValidPathString(named) else None
            of = at.GetParent() if at and at.GetTypeName() == "GeomSubset" else at
            if not (at and of and of.GetTypeName() == "Mesh" and at.IsDefined() and not at.IsAbstract()):
                _none(stage, shown, prim, faults)
            else:
                with problems.gathered():
                    made = _mesh(of, at, prim, World(stage, problems))
                note(problems.diagnostics, shown, faults)
    except Broken:
        pass
    return tuple(faults.diagnostics) or made or ()


def _mesh(of: Usd.Prim, at: Usd.Prim, named: str, world: World) -> Mesh:
    """A mesh, one of its subsets, or the rest of it. Raises StageError."""
    bounded(of)
    faces = None
    if at != of:
        faces = meshes.subset(at)
    elif named.endswith(REST):
        faces = next((rest for part, rest in meshes.parts(of) if part == of), None)
        if faces is None:
            refuse(of, "there are no faces of it that are in none of its subsets", f"leave out `{REST}`")
    return meshes.mesh(of, split(world.matrix(of), of).stretch, faces)


def _none(stage: Usd.Stage, shown: str, prim: str, faults: Faults) -> None:
    every = Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies())
    known = [str(p.GetPath()) for p in every if p.GetTypeName() == "Mesh"]
    faults.add(FilePlace(shown), f"there is no mesh `{prim[:80]}`", suggestion(prim, known) or "it has no meshes")
