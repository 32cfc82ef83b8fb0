"""Traces of engines as files: one NPZ archive a case.

`CASE.npz` holds the arrays `bodies` (N,), `position` (T, N, 3), `orientation` (T, N, 4), `linear_velocity` (T, N, 3)
and `angular_velocity` (T, N, 3), or the text `refusal` alone: why the engine did not execute the case.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from usdphysics_conformance.case import Case, ConformanceError, Motion, Trace

#: The arrays of a trace other than `bodies`, and the length of their last axis.
ARRAYS = {"position": 3, "orientation": 4, "linear_velocity": 3, "angular_velocity": 3}


class Refusal(ConformanceError):
    """The engine refused to execute the case, or gave up."""


def make_trace(case: Case, bodies: Sequence[str], arrays: Mapping[str, Any]) -> Trace:
    """The trace of a case from arrays: names or paths of N bodies, and T samples of each as in a file.

    Bodies that are not rigid bodies of the stage are left out. Raises ConformanceError if a rigid body or an array is
    missing, or if an array has another shape or numbers that are not finite.
    """
    names = [str(body).rpartition("/")[2] for body in bodies]
    if missing := [name for name in case.bodies if name not in names]:
        raise ConformanceError(f"the body `{missing[0]}` is missing; `bodies` names {', '.join(names) or 'none'}")
    motions = []
    for name, width in ARRAYS.items():
        if name not in arrays:
            raise ConformanceError(f"the array `{name}` is missing")
        array, shape = np.asarray(arrays[name], float), (case.samples, len(names), width)
        if array.shape != shape:
            raise ConformanceError(f"`{name}` has the shape {array.shape}, expected {shape}")
        if not np.isfinite(array).all():
            raise ConformanceError(f"`{name}` has numbers that are not finite")
        motions.append(array)
    if np.abs(np.linalg.norm(motions[1], axis=-1) - 1).max() > 1e-3:
        raise ConformanceError("`orientation` has quaternions that are not of length 1")
    return {name: Motion(*(array[:, i] for array in motions)) for i, name in enumerate(names) if name in case.bodies}


def read_trace(case: Case, path: Path) -> Trace:
    """The trace of a case in a file.

    Raises Refusal if the engine refused the case, ConformanceError if there is no such file or if it is not a trace.
    """
    if not path.is_file():
        raise ConformanceError(f"{path}: there is no trace of the case")
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = dict(file)
    except (OSError, ValueError, EOFError, BadZipFile, AttributeError, TypeError) as error:
        raise ConformanceError(f"{path}: not an NPZ archive of arrays: {error}") from None
    if "refusal" in arrays:
        raise Refusal(f"{path}: {arrays['refusal']}")
    try:
        return make_trace(case, [str(body) for body in np.atleast_1d(arrays.pop("bodies", ()))], arrays)
    except (ConformanceError, ValueError) as error:
        raise ConformanceError(f"{path}: {error}") from None


def write_trace(path: Path, trace: Trace) -> None:
    """Writes a trace as an NPZ archive."""
    arrays: dict[str, Any] = {
        name: np.stack([getattr(motion, name) for motion in trace.values()], axis=1) for name in ARRAYS
    }
    np.savez_compressed(path, bodies=np.array(list(trace)), **arrays)


def write_refusal(path: Path, reason: str) -> None:
    """Writes why an engine did not execute a case."""
    np.savez_compressed(path, refusal=np.array(reason))
