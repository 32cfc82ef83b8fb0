"""Measurements of a run that has not ended, kept in a folder beside its results: the same command goes on from them."""

from __future__ import annotations

import hashlib
import io
import json
import shutil
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

import numpy as np

from wmspec.core.code_digest import package_digest
from wmspec.core.disk_cache import DiskCache
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.clips.measure import Measurement
from wmspec.eval.clips.packages import opencv

#: Entries of a folder: more clips than a run has.
_MOST = 1_000_000
#: Packages on whose code a measurement depends.
_PACKAGES = ("wmspec.eval.clips", "wmspec.dataset.film")


class KeptMeasurements:
    """The measurements of finished clips, by their content, in `RESULTS.clips`.

    After an error (no permission, a full disk, a damaged file) a clip is measured again.
    """

    def __init__(self, output: Path, dataset: DatasetReader) -> None:
        self._place = output.with_suffix(".clips")
        self._store = DiskCache(self._place, _MOST)
        digests = [package_digest(name) for name in _PACKAGES]
        self._shared = [*digests, version("numpy"), opencv().__version__, dataset.manifest["fingerprint"]]

    def get(self, about: tuple[object, ...], measured: Callable[[], Measurement]) -> Measurement:
        """Return the measurement of a clip described by `about`, kept or made by `measured`."""
        name = hashlib.sha256(json.dumps([*self._shared, *about]).encode()).hexdigest()
        if (content := self._store.read(name)) is not None:
            try:
                with np.load(io.BytesIO(content), allow_pickle=False) as file:
                    return Measurement.of({key: file[key] for key in file.files})
            except (OSError, ValueError, KeyError, TypeError):
                pass  # from another version
        made, sink = measured(), io.BytesIO()
        np.savez(sink, **made.arrays())
        self._store.write(name, sink.getvalue())
        return made

    def clear(self) -> None:
        """Remove the folder, once the results are written."""
        shutil.rmtree(self._place, ignore_errors=True)
