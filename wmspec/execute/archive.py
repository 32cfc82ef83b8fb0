"""Traces on disk: an `.npz` file with the stage that was executed, so that it can be drawn without its spec."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Sdf, Tf, Usd

import wmspec.usd.schema  # noqa: F401  importing it registers the schemas
from wmspec.diagnostics import WmsError
from wmspec.places import FilePlace
from wmspec.scene.model import Contact, Trace

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
        raise WmsError(f"cannot be written: {error.strerror}", FilePlace(str(path))) from None


def load(path: Path) -> tuple[Usd.Stage, Trace]:
    """A trace and the stage that it is of, as `save` wrote them. Raises WmsError if the file is something else."""
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays: dict[str, Any] = dict(file)
        layer = Sdf.Layer.CreateAnonymous(".usda")
        layer.ImportFromString(str(arrays["stage"]))
        contacts = zip(arrays["contacts"].tolist(), arrays["contact_times"].tolist(), strict=True)
        trace = Trace(
            str(arrays["engine"]),
            tuple(arrays["bodies"].tolist()),
            **{name: arrays[name] for name in ARRAYS},
            contacts=tuple(Contact(*pair, *times) for pair, times in contacts),
        )
    except FileNotFoundError:
        raise WmsError("there is no such file", FilePlace(str(path))) from None
    except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile, Tf.ErrorException):
        raise WmsError(
            "not a trace of wmspec", FilePlace(str(path)), "`wmspec run SPEC -o trace.npz` writes one"
        ) from None
    return Usd.Stage.Open(layer), trace
