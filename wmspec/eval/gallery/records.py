"""Records of a gallery: one for each question of an instance, with the pictures of every engine."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from wmspec.core.safe_io import load_image
from wmspec.dataset.build.films import shown_film
from wmspec.dataset.build.format_units import format_reading, format_value
from wmspec.dataset.build.reader import CHANNELS, DatasetReader
from wmspec.dataset.build.rows import Row
from wmspec.eval.models import results

#: Maximum length of a displayed reply (characters).
MAX_TEXT_LENGTH = 400


@dataclass(frozen=True)
class GalleryReplies:
    """All replies by question id; `models` are their authors, in order."""

    models: tuple[str, ...]
    by_id: dict[str, list[Row]]

    def of(self, id: str) -> list[dict[str, Any]]:
        """Return the replies to a question, in the page's format."""
        shown = ("model", "parsed", "right", "status")
        return [
            {key: row[key] for key in shown} | {"text": row["text"][:MAX_TEXT_LENGTH]} for row in self.by_id.get(id, ())
        ]


NO_REPLIES = GalleryReplies((), {})


def read(paths: Sequence[Path]) -> GalleryReplies:
    """Read result files, or folders of them. Raises WmsError if one is invalid, or a folder has none."""
    by_id: dict[str, list[Row]] = {}
    for path in results.files_of(paths):
        for row in results.read(path)[0]:
            by_id.setdefault(row["id"], []).append(row)
    models = sorted({row["model"] for rows in by_id.values() for row in rows})
    return GalleryReplies(tuple(models), by_id)


Record = dict[str, Any]

#: Stores a picture or a film (mp4) for the page, and returns its URL.
Store = Callable[[bytes], str]


#: Maximum number of rejected instances listed, and what is listed of each.
MAX_REJECTED, REJECTION = 2_000, ("task", "index", "question", "engine", "reason", "detail")


def about(dataset: DatasetReader, replies: GalleryReplies = NO_REPLIES) -> Record:
    """Return the page's information on the dataset, its tasks, its rejections, and the models that answered."""
    manifest = dataset.manifest
    rejected = manifest.get("rejected", {}).get("list", ())
    return {
        "fingerprint": str(manifest.get("fingerprint", ""))[:16],
        "models": list(replies.models),
        "rejected": [[each[key] for key in REJECTION] for each in rejected[:MAX_REJECTED]],
        "rejections": len(rejected),
        "name": dataset.folder.resolve().name,
        "engines": list(dataset.engines),
        "runs_of": list(dataset.engines) if dataset.rows_of == "engines" else [],
        **{key: manifest[key] for key in ("rows", "seed", "size", "versions")},
        "tasks": {
            name: {
                "title": task["title"] or name,
                "dimension": task["dimension"],
                "description": task["description"],
                "kept": sum(task["rows"].values()),
                "rejected": task["rejected"],
            }
            for name, task in manifest["tasks"].items()
        },
    }


def records(
    dataset: DatasetReader,
    per_task: int,
    put: Store,
    replies: GalleryReplies = NO_REPLIES,
    put_film: Store | None = None,
) -> Iterator[Record]:
    """Yield the records of at most `per_task` instances of each task, evenly spaced; without `put_film`, no films."""

    def films(row: Row) -> Record | None:
        film = shown_film(dataset.folder, row)
        if film is None or put_film is None:
            return None
        span = f"{film.camera}, {film.start:.3g} s to {film.end:.3g} s"
        return {"shown": put_film(film.mp4()), "whole": put_film(film.mp4(whole=True)), "span": span}

    for task in dataset.tasks:
        units = dataset.units(task)
        kept = sorted({row["index"] for row in dataset.rows(task, ["index"])})
        shown = min(per_task, len(kept))
        chosen = {kept[i * len(kept) // shown] for i in range(shown)}
        columns = [name for name in dataset.columns(task) if name == IDS or name not in CHANNELS]
        rows = sorted(dataset.rows(task, columns, chosen), key=lambda r: (r["index"], r["question"]))
        for _, same in groupby(rows, key=lambda r: (r["index"], r["question"])):
            yield _record(list(same), units, dataset.engines, put, films, replies)


def _record(
    rows: list[Row],
    units: dict[str, str],
    engines: tuple[str, ...],
    put: Store,
    films: Callable[[Row], Record | None],
    replies: GalleryReplies,
) -> Record:
    first = rows[0]
    difference = first.get("difference")  # of the stimulus, as text and for sorting; None without one
    margins = [row["margin"] for row in rows if row["margin"] is not None]
    return {
        "id": f"{first['task']}/{first['index']}" + (f"/q{first['question']}" if first["question"] else ""),
        "task": first["task"],
        "index": first["index"],
        "factors": _varied(first, "factor", units),
        "nuisances": _varied(first, "nuisance", units),
        "difference": difference and f"{difference['name']}: {format_value(difference['value'], difference['unit'])}",
        "strength": difference and {key: difference[key] for key in ("name", "value")},
        "margin": min(margins) if margins else None,
        "accuracy": _accuracy([reply for row in rows for reply in replies.of(row["id"])]),
        "answer": _answer(first),
        "agreement": _agreement(rows),
        "runs": [
            _run(row, put, replies) | {"film": films(row)}
            for row in sorted(rows, key=lambda r: engines.index(r["engine"]))
        ],
    }


def _varied(row: Row, sort: str, units: dict[str, str]) -> dict[str, str]:
    return {k.partition(".")[2]: format_value(v, units.get(k, "")) for k, v in row.items() if k.startswith(f"{sort}.")}


def _accuracy(replies: list[Record]) -> dict[str, float]:
    """Return the share of right replies of each model; `""` is all models."""
    by_model: dict[str, list[bool]] = {}
    for reply in replies:
        for name in ("", reply["model"]):
            by_model.setdefault(name, []).append(reply["right"])
    return {name: sum(right) / len(right) for name, right in by_model.items()}


def _answer(row: Row) -> str:
    """Return the filter value of the answer: the true words, or the position of the true picture."""
    return f"picture {'ABCDEFGHIJKLMNOPQRSTUVWXYZ'[row['answer']]}" if row["option_image"] else str(row["answer_value"])


def _agreement(rows: list[Row]) -> str:
    """Return whether the outcomes of all engines select the same option."""
    votes = [(row, vote) for row in rows for vote in row["agreement"]]
    if len({vote["engine"] for _, vote in votes}) < 2:
        return "one engine"
    agree = all(v["answer"] == row["answer"] and not v.get("rejected") for row, v in votes)
    return "all agree" if agree else "some differ"


def _run(row: Row, put: Store, replies: GalleryReplies) -> Record:
    """Return one engine's version of a question."""
    looks = zip(row["context"], row["context_camera"], row["context_time"], strict=True)
    return {
        **{key: row[key] for key in ("engine", "renderer", "text")},
        "context": [{"src": put(p["bytes"]), "camera": c, "time": f"{t:.3g} s"} for p, c, t in looks],
        "options": _options(row, put),
        "true": row["answer"],
        "value": row["answer_value"],
        "measured": [[m["name"], format_reading(m["name"], m["value"])] for m in row["measured"]],
        "margin": None if row["margin"] is None else f"{row['margin']:.2g}",
        "paths": paths(row),
        "replies": replies.of(row["id"]),
        "votes": [[v["engine"], v["answer"], v.get("rejected"), v.get("apart")] for v in row["agreement"]],
    }


def _options(row: Row, put: Store) -> list[Record]:
    shown = [put(p["bytes"]) for p in row["option_image"]] or row["option_text"] or []
    key = "src" if row["option_image"] else "text"
    kinds, names, changes = row["option_kind"], row["option_name"], row["option_change"]
    return [
        {key: what, "kind": kind, "name": name, "change": change}
        for what, kind, name, change in zip(shown, kinds, names, changes, strict=True)
    ]


#: The columns with segmentation ids and names.
IDS, NAMES = "context_ids", "context_names"
#: Minimum motion of an object (px); the visible centre also shifts under occlusion.
MIN_MOTION = 3.0


def paths(row: Row) -> list[dict[str, object]]:
    """Return the name of each moving object, and the centre of its visible part in each picture (px), or null.

    Empty for a row without ids, or with pictures of several cameras.
    """
    if not row.get(IDS) or len(set(row["context_camera"])) > 1:
        return []
    seen = [np.asarray(load_image(each["bytes"], "PNG")) for each in row[IDS]]
    return list(_moving_paths(seen, row[NAMES]))


def _moving_paths(pictures: list[np.ndarray], names: list[str]) -> Iterator[dict[str, object]]:
    for place, name in enumerate(names, 1):
        middles = [_centre(image == place) for image in pictures]
        seen = np.array([middle for middle in middles if middle is not None])
        if len(seen) > 1 and float(np.ptp(seen, axis=0).max()) >= MIN_MOTION:
            yield {"name": name, "points": middles}


def _centre(mask: np.ndarray) -> list[float] | None:
    rows, columns = np.nonzero(mask)
    return [round(float(columns.mean()), 1), round(float(rows.mean()), 1)] if len(rows) else None
