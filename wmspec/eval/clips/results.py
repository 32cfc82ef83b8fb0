"""Results of clips: rows like those of other models, with more columns, and the measurements beside them."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import regular_file
from wmspec.dataset.build.files import with_remedies
from wmspec.dataset.build.rows import Row
from wmspec.eval.clips.decide import REASONS, Decision, decide, track_error
from wmspec.eval.clips.measure import Measurement
from wmspec.eval.clips.questions import FilmQuestion
from wmspec.eval.models import results
from wmspec.eval.models.causes import NO_FUTURE

#: The version of the decision rules.
RULES_VERSION = 4

#: The columns beyond those of all results: type and description.
COLUMNS: dict[str, tuple[pa.DataType, str]] = {
    "why": (pa.list_(pa.string()), "why a clip counts as none of the futures"),
    "nearest": (pa.int64(), "the place of the nearest future, whether or not it is chosen"),
    "distances": (pa.list_(pa.float64()), "the distance (object widths) to the future of each option"),
    "ratio": (pa.float64(), "the distance to the nearest future, relative to that between it and its nearest rival"),
    "end_ratio": (pa.float64(), "the same for the last three frames"),
    "margin": (pa.float64(), "how much farther the second nearest future is, as a share of its distance"),
    "tempo": (pa.float64(), "how fast the clip runs: 1 is real time"),
    "delay": (pa.float64(), "how late (s) it starts"),
    "frozen": (pa.bool_(), "whether nothing moves where the futures move"),
    "missing": (pa.float64(), "the share of frames in which an object is lost or too many"),
    "area_drift": (pa.float64(), "the area of the objects at the end, relative to that at the beginning"),
    "track_error": (pa.float64(), "the mean distance (object widths) from the true future"),
    "final_error": (pa.float64(), "the distance (object widths) from its end"),
    "track_floor": (pa.float64(), "the mean distance of the true futures of two engines; null if one engine has films"),
    "final_floor": (pa.float64(), "the distance of their ends"),
    "miou": (pa.float64(), "the mean overlap (IoU) of the objects with those of the true future"),
    "background_rmse": (pa.float64(), "the error of the background (root mean square, of 1)"),
    "piq_spatial": (pa.float64(), "Physics-IQ: where motion happens (IoU)"),
    "piq_spatiotemporal": (pa.float64(), "Physics-IQ: where and when (mean IoU of frames)"),
    "piq_weighted": (pa.float64(), "Physics-IQ: where and how much"),
    "piq_mse": (pa.float64(), "Physics-IQ: the mean squared error of pixels"),
    "piq_margin": (pa.float64(), "the mean of the three overlaps minus that of the best wrong future"),
    "fit": (pa.string(), "how the clip was fitted to the size of the films: stretch, bars or crop"),
    "begins": (pa.string(), "what the clip begins with: context, first (the last picture shown) or after (it)"),
    "rate": (pa.int64(), "the frames per second of the films"),
    "zoom": (pa.float64(), "the largest zoom of the camera"),
}
SCHEMA = pa.schema([*results.SCHEMA, *(pa.field(name, kind) for name, (kind, _) in COLUMNS.items())])


def common(question: FilmQuestion, sample: int, model: str, version: str, prompt: str, prompt_hash: str) -> Row:
    """Return the columns that do not depend on the clip."""
    known = dict.fromkeys(SCHEMA.names)
    count = len(question.options)
    return (
        known
        | question.columns
        | {
            "model": model,
            "model_version": version or None,
            "prompt": prompt,
            "prompt_hash": prompt_hash,
            "permutation": 0,
            "sample": sample,
            "order": list(range(count)),
            "labels": "numbers",
            "options": [None] * count,
            "answer": question.answer,
            "rate": question.rate,
            "text": "",
        }
    )


def failed(row: Row, reason: str) -> Row:
    """Return the row of a clip that cannot be read."""
    return row | {"status": "error", "error": reason, "right": False}


def scored(row: Row, measured: Measurement, rate: int, floor: tuple[float, float] | None) -> Row:
    """Return the row of a measured clip. The answer is used only to compare with the decision."""
    decision = decide(measured, rate)
    return row | _decided(decision, row["answer"]) | _compared(measured, row["answer"], floor)


def chosen(place: int | None, answer: int, why: str) -> Row:
    """Return the columns of a choice; `why` says why there is none."""
    return {
        "parsed": place,
        "right": place == answer,
        "status": "unparsed" if place is None else "answered",
        "text": why if place is None else "",
    }


def _decided(decision: Decision, answer: int) -> Row:
    """Return the columns of a decision, whose fields are columns of the same names."""
    why = f"{NO_FUTURE}: {'; '.join(REASONS[name] for name in decision.why)}"
    values = {name: list(v) if isinstance(v, tuple) else v for name, v in asdict(decision).items() if name != "choice"}
    return values | chosen(decision.choice, answer, why) | {"error": None, "frozen": "frozen" in decision.why}


def _compared(measured: Measurement, answer: int, floor: tuple[float, float] | None) -> Row:
    """Return the columns that compare a clip with the true future."""
    along, end = track_error(measured.points[answer], measured.futures[answer], measured.widths)
    iq = measured.physics_iq
    overlaps = iq[:, :3].mean(axis=1)
    return {
        "area_drift": _area_drift(measured),
        "track_error": along,
        "final_error": end,
        "track_floor": None if floor is None else floor[0],
        "final_floor": None if floor is None else floor[1],
        "miou": float(measured.overlap[answer]),
        "background_rmse": measured.background_rmse,
        "piq_spatial": float(iq[answer, 0]),
        "piq_spatiotemporal": float(iq[answer, 1]),
        "piq_weighted": float(iq[answer, 2]),
        "piq_mse": float(iq[answer, 3]),
        "piq_margin": float(overlaps[answer] - np.delete(overlaps, answer).max()),
        "fit": measured.fit,
        "begins": measured.begins,
        "zoom": measured.zoom,
    }


def _area_drift(measured: Measurement) -> float | None:
    """Return the summed area of the objects in the last quarter of frames, relative to the first quarter."""
    quarter = max(1, measured.areas.shape[1] // 4)
    first, last = measured.areas[:, :quarter].mean(axis=1).sum(), measured.areas[:, -quarter:].mean(axis=1).sum()
    return float(last / first) if first > 0 else None


# ---------------------------------------------------------------- measurements


def tracks_path(path: Path) -> Path:
    """Return the path of the measurements of results."""
    return path.with_suffix(".tracks.npz")


def write_tracks(path: Path, measured: Mapping[tuple[str, int], Measurement]) -> None:
    """Write the measurements of clips by question and sample. Raises WmsError if that fails."""
    sink = io.BytesIO()
    keys = sorted(measured)
    arrays: dict[str, Any] = {"keys": np.array(json.dumps(keys))}
    for number, key in enumerate(keys):
        arrays |= {f"{number}/{name}": value for name, value in measured[key].arrays().items()}
    np.savez_compressed(sink, **arrays)
    results.write_atomically(tracks_path(path), sink.getvalue())


def read_tracks(path: Path) -> dict[tuple[str, int], Measurement]:
    """Return the measurements beside results. Raises WmsError if they are missing or damaged."""
    place = tracks_path(path)
    try:
        with with_remedies(place), np.load(regular_file(place), allow_pickle=False) as file:
            keys = json.loads(str(file["keys"]))
            names = [name.partition("/") for name in file.files]
            return {
                (str(id), int(sample)): Measurement.of(
                    {name: file[f"{number}/{name}"] for prefix, _, name in names if prefix == str(number) and name}
                )
                for number, (id, sample) in enumerate(keys)
            }
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, RecursionError):
        raise WmsError("not the measurements of clips", FilePlace(str(place)), "evaluate the clips again") from None


def rescore(path: Path, rows: Sequence[Row]) -> list[Row]:
    """Return rows of results decided again from their measurements."""
    measured = read_tracks(path)
    made = []
    for row in rows:
        one = measured.get((row["id"], row["sample"]))
        if row["status"] == "error" or one is None:
            made.append(row)
            continue
        floor = None if row["track_floor"] is None else (row["track_floor"], row["final_floor"])
        made.append(scored(row, one, row["rate"], floor))
    return made
