"""Traces on disk: an `.npz` file with the executed stage, so that it can be rendered without its spec."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Sdf, Tf, Usd

import wmspec.sim.usd.schema  # noqa: F401  importing it registers the schemas
from wmspec.core.diagnostics import Diagnostic, StageError, WmsError
from wmspec.core.limits import TRACE_BYTES, TooLarge
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import is_file_name, open_file, regular_file, writing
from wmspec.sim.scene.model import Contact, Trace
from wmspec.sim.usd.composed import require_bounded_layer
from wmspec.sim.usd.files import complaint

ARRAYS = ("time", "position", "orientation", "linear_velocity", "angular_velocity")


def save(stage: Usd.Stage, trace: Trace, path: Path, notes: Sequence[Diagnostic] = ()) -> None:
    """Write a trace with its stage and the warnings of its execution. Raises WmsError if the file is not writable."""
    more: dict[str, Any] = {"notes": np.array([str(note) for note in notes])} if notes else {}
    touched = [(c.first, c.second, c.start, c.stop) for c in trace.contacts]
    pairs, times = [t[:2] for t in touched], [t[2:] for t in touched]
    with writing(path), path.open("wb") as file:
        np.savez_compressed(
            file,
            stage=np.array(_flat(stage)),
            engine=np.array(trace.engine),
            bodies=np.array(trace.bodies, dtype=np.str_),
            contacts=np.array(pairs, dtype=np.str_).reshape(-1, 2),
            contact_times=np.array(times, dtype=np.float64).reshape(-1, 2),
            **{name: getattr(trace, name) for name in ARRAYS},
            **more,
        )


def _flat(stage: Usd.Stage) -> str:
    """Return a stage as one layer. Raises StageError if an opinion of it cannot be composed."""
    try:
        return str(stage.Flatten().ExportToString())
    except Tf.ErrorException as error:
        raise StageError(f"cannot be saved: {complaint(error)}", help="remove or correct it") from None


def load(path: Path) -> tuple[Usd.Stage, Trace]:
    """Return a trace and its stage from a file of `save`.

    Raises WmsError if the file has another format, exceeds the memory limit, or contains invalid numbers.
    """
    place = FilePlace(str(path))
    try:
        _check_size(regular_file(path))
        with open_file(path) as content, np.load(content, allow_pickle=False) as file:
            arrays: dict[str, Any] = dict(file)
        contacts = zip(arrays["contacts"].tolist(), arrays["contact_times"].tolist(), strict=True)
        trace = Trace(
            str(arrays["engine"]),
            tuple(arrays["bodies"].tolist()),
            **{name: np.asarray(arrays[name]) for name in ARRAYS},
            contacts=tuple(Contact(*pair, *times) for pair, times in contacts),
        )
        fault = _violation(trace)
        stage = None if fault else _stage(str(arrays["stage"]))
    except FileNotFoundError:
        raise WmsError("there is no such file", place) from None
    except TooLarge as error:
        raise error.at(place) from None
    except Exception:  # noqa: BLE001  archives of others can fail to be read in any way
        raise WmsError("not a trace of wmspec", place, "`wmspec run SPEC -o trace.npz` writes one") from None
    if stage is None:
        fault = fault or "its stage uses files of its own"
        raise WmsError(f"not a trace of wmspec: {fault}", place, "`wmspec run SPEC -o trace.npz` writes one")
    return stage, trace


def _check_size(path: Path) -> None:
    """Raise TooLarge or ValueError if an archive unpacks to more than the limit, or than its headers declare."""
    with open_file(path) as content, zipfile.ZipFile(content) as archive:
        if sum(member.file_size for member in archive.infolist()) > TRACE_BYTES.most:
            raise TRACE_BYTES.exceeded()
        for member in archive.infolist():
            with archive.open(member) as file:
                version = np.lib.format.read_magic(file)
                read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
                shape, _, kind = read(file)
                if math.prod(shape) * kind.itemsize != member.file_size - file.tell():
                    raise ValueError("an array is not as long as it says")


def _stage(text: str) -> Usd.Stage | None:
    """Return the flattened stage of a trace, or None if it refers to other layers.

    A flattened stage with instances refers to its own prims. Raises TooLarge if it would have too many prims.
    """
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(text)
    if any(layer.GetCompositionAssetDependencies()):
        return None
    require_bounded_layer(layer)
    return Usd.Stage.Open(layer)


def _violation(trace: Trace) -> str:
    """Return a description of invalid numbers in a trace, or an empty string."""
    t, n = len(trace.time.reshape(-1)), len(trace.bodies)
    expected = dict(zip(ARRAYS, [(t,), (t, n, 3), (t, n, 4), (t, n, 3), (t, n, 3)], strict=True))
    for name, shape in expected.items():
        array = getattr(trace, name)
        if array.dtype != np.float64 or array.shape != shape:
            return f"`{name}` is {array.dtype} {array.shape}, expected float64 {shape}"
        if not np.isfinite(array).all():
            return f"`{name}` has numbers that are not finite"
    if t == 0 or trace.time[0] != 0 or (np.diff(trace.time) <= 0).any():
        return "its times do not begin at 0 and go on from there"
    if not is_file_name(trace.engine):
        return "its engine has no name"
    if len(set(trace.bodies)) < n or not all(isinstance(name, str) and name for name in trace.bodies):
        return "its bodies have duplicate names"
    with np.errstate(over="ignore"):
        lengths = np.linalg.norm(trace.orientation, axis=2)
    if np.abs(lengths - 1).max(initial=0) > _UNIT:
        return "an orientation is no unit quaternion"
    known = set(trace.bodies)
    for contact in trace.contacts:
        if not {contact.first, contact.second} <= known or not 0 <= contact.start <= contact.stop <= trace.time[-1] + 1:
            return "a contact is of no bodies of it, or at no time of it"
    return ""


#: Permitted deviation of a quaternion's norm from 1.
_UNIT = 1e-3
