"""Opens untrusted USD files: bounded, silent, with all layers below the spec's folder."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path

from pxr import Sdf, Usd, UsdUtils

from wmspec.core.diagnostics import Diagnostic, Report, StageError, suggestion
from wmspec.core.limits import POINTS, PRIMS, TooLarge
from wmspec.core.places import FilePlace
from wmspec.lang.importers.model import Faults, UnreadableAsset
from wmspec.sim.shapes import Mesh
from wmspec.sim.usd import meshes
from wmspec.sim.usd.files import error_text, open_stage_file
from wmspec.sim.usd.frames import StageFrame, split_transform
from wmspec.sim.usd.prims import refuse, value
from wmspec.sim.usd.substitutions import Substitutions
from wmspec.sim.usd.unsupported import report_missing_files

#: Suffix of a mesh path for the faces that belong to no subset.
REST = ".rest"


@contextmanager
def stage_of(path: Path, folder: Path | None, shown: str, faults: Faults) -> Iterator[Usd.Stage]:
    """Open the stage of a USD file; messages call it `shown`, and its layers must be below `folder`, if given.

    Raises Broken if it cannot be read, or if an error occurs during its use.
    """
    quiet = UsdUtils.CoalescingDiagnosticDelegate()  # suppresses USD's output: errors are reported below
    try:
        stat = path.stat()
        stage = _stage(str(path), stat.st_mtime_ns, stat.st_size)
        _check_layers(stage, folder, shown, faults)
        yield stage
    except UnreadableAsset:
        raise
    except TooLarge as error:
        limit = error.diagnostics[0]
        raise faults.stop(FilePlace(shown), limit.message, limit.help) from None
    except Exception as error:  # noqa: BLE001  plug-ins may raise any type
        raise faults.stop(
            FilePlace(shown), f"cannot be read: {error_text(error)}", "fix it, or export it again"
        ) from None
    finally:
        del quiet


@lru_cache(maxsize=1)
def _stage(path: str, _changed: int, _size: int) -> Usd.Stage:
    """Return the stage of a file. The last one is cached: its meshes are requested one by one."""
    return open_stage_file(Path(path), Path(path).name)


def _check_layers(stage: Usd.Stage, folder: Path | None, shown: str, faults: Faults) -> None:
    """Report missing layers, layers outside the folder, and too large stages."""
    problems = Report(StageError)
    report_missing_files(stage, problems)
    add_problems(problems.diagnostics, shown, faults, folder)
    if faults.diagnostics:
        raise UnreadableAsset
    for layer in stage.GetUsedLayers():
        beside = folder is None or layer.anonymous or Path(layer.realPath).resolve().is_relative_to(folder.resolve())
        if not beside:
            what = f"uses `{Path(layer.identifier).name}`, which is not below the spec's folder"
            raise faults.stop(FilePlace(shown), what, "put it beside the asset")
    every = Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies())
    if any(count > PRIMS.most for count, _ in enumerate(every)):
        raise faults.stop(FilePlace(shown), PRIMS.sentence, PRIMS.help)


def add_problems(problems: Iterable[Diagnostic], shown: str, faults: Faults, folder: Path | None = None) -> None:
    """Add errors about prims of the file to the faults."""
    home = f"{folder.resolve()}/" if folder is not None else ""
    for problem in problems:
        reason = problem.message.replace(home, "") if home else problem.message
        faults.add(FilePlace(shown, element=f"`{problem.place}`"), reason[:300], problem.help)


def add_substitutions(notes: Substitutions, shown: str, faults: Faults) -> None:
    """Add the substitutions of a reading as warnings."""
    for note in notes.diagnostics:
        reason, _, taken = note.message.rpartition(": ")
        place = FilePlace(shown, element=f"`{note.place}`")
        faults.approximate(place, reason or taken, taken if reason else "", note.help)


def check_mesh_size(prim: Usd.Prim) -> None:
    """Raise StageError for a mesh that is too large."""
    if max(len(value(prim, name, ())) for name in ("points", "faceVertexIndices")) > POINTS.most:
        refuse(prim, f"it {POINTS.sentence}", POINTS.help)


def mesh(path: Path, folder: Path | None, shown: str, prim: str) -> Mesh | tuple[Diagnostic, ...]:
    """Return the mesh at a prim of a USD file, or the polygons of a GeomSubset, or the errors.

    Points are in the prim's rigid frame and include scale, mirroring and skew. `shown` is the file's name in messages;
    all its layers are below `folder`, if given.
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
                with problems.collect_errors():
                    made = _mesh(of, at, prim, StageFrame(stage, problems))
                add_problems(problems.diagnostics, shown, faults)
    except UnreadableAsset:
        pass
    return tuple(faults.diagnostics) or made or ()


def _mesh(of: Usd.Prim, at: Usd.Prim, named: str, world: StageFrame) -> Mesh:
    """Return a mesh, one of its subsets, or its remaining faces. Raises StageError."""
    check_mesh_size(of)
    faces = None
    if at != of:
        faces = meshes.subset(at)
    elif named.endswith(REST):
        faces = next((rest for part, rest in meshes.parts(of) if part == of), None)
        if faces is None:
            refuse(of, "there are no faces of it that are in none of its subsets", f"leave out `{REST}`")
    return meshes.mesh(of, split_transform(world.matrix(of), of).stretch, faces)


def _none(stage: Usd.Stage, shown: str, prim: str, faults: Faults) -> None:
    every = Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies())
    known = [str(p.GetPath()) for p in every if p.GetTypeName() == "Mesh"]
    faults.add(FilePlace(shown), f"there is no mesh `{prim[:80]}`", suggestion(prim, known) or "it has no meshes")
