"""Comparison of films with the same films made again."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from wmspec.core.diagnostics import WmsError
from wmspec.core.safe_io import read_bytes
from wmspec.dataset.build.reader import DatasetReader
from wmspec.dataset.film.codec import decode
from wmspec.dataset.verify.compare import NEAR_PIXELS
from wmspec.dataset.verify.model import Difference


def film_differences(dataset: DatasetReader, films: Mapping[str, bytes]) -> Iterator[Difference]:
    """Yield the differences of films from those made again; equal frames in other bytes are equal films."""
    known = dataset.films
    for path in sorted(films):
        if path not in known:
            yield Difference(path, "", "the film is not in the dataset")
            continue
        there = read_bytes(dataset.folder / path)
        if there == films[path]:
            continue
        try:
            x, y = (decode(content).astype(np.float64) for content in (there, films[path]))
        except WmsError as error:
            yield Difference(path, "", str(error))
            continue
        if x.shape != y.shape:
            yield Difference(path, "", f"the film is {x.shape} in the dataset, {y.shape} here")
        elif (apart := np.abs(x - y)).any():
            words = f"the film differs in {(apart > 0).mean():.2%} of its values, by {apart.mean():.2g} on average"
            yield Difference(path, "", words, bool(apart.mean() < NEAR_PIXELS))
