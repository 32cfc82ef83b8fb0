"""Traces on disk: an `.npz` file with the stage that was executed, so that it can be drawn without its spec."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Sdf, Tf, Usd

import wmspec.usd.schema  # noqa: F401  importing it registers the schemas
from wmspec.diagnostics import WmsError
from wmspec.scene.model import Contact, Scene, Trace
from wmspec.usd import read

ARRAYS = ("time", "position", "orientation", "linear_velocity", "angular_velocity")


def save(stage: Usd.Stage, trace: Trace, path: Path) -> None:
    """Write a trace and the stage it is of. Raises WmsError if that is impossible."""
    touched = [(c.first, c.second, c.start, c.stop) for c in trace.contacts]
    pairs, times = [t[:2] for t in touched], [t[2:] for t in touched]
    try:
        with path.open("wb") as file:
            np.savez_compressed(
                file,
                stage=np.array(stage.Flatten().ExportToString()),
                engine=np.array(trace.engine),
                bodies=np.array(trace.bodies, dtype=np.str_),
                contacts=np.array(pairs, dtype=np.str_).reshape(-1, 2),
                contact_times=np.array(times, dtype=np.float64).reshape(-1, 2),
                **{name: getattr(trace, name) for name in ARRAYS},
            )
    except OSError as error:
        raise WmsError(f"{path}: cannot be written: {error.strerror}") from None


def load(path: Path) -> tuple[Scene, Trace]:
    """A trace and its scene, as `save` wrote them. Raises WmsError if the file is something else."""
    try:
        with np.load(path, allow_pickle=False) as file:
            found: dict[str, Any] = dict(file)
        layer = Sdf.Layer.CreateAnonymous(".usda")
        layer.ImportFromString(str(found["stage"]))
        contacts = zip(found["contacts"].tolist(), found["contact_times"].tolist(), strict=True)
        trace = Trace(
            str(found["engine"]),
            tuple(found["bodies"].tolist()),
            **{name: found[name] for name in ARRAYS},
            contacts=tuple(Contact(*pair, *times) for pair, times in contacts),
        )
    except FileNotFoundError:
        raise WmsError(f"{path}: there is no such file") from None
    except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile, Tf.ErrorException):
        raise WmsError(f"{path}: not a trace of wmspec; `wmspec run SPEC -o trace.npz` writes one") from None
    return read(Usd.Stage.Open(layer)), trace
