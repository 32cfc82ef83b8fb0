"""What the gallery knows of a question: one record for each instance, every engine's pictures in it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import groupby
from typing import Any

from wmspec.write.reader import DatasetReader
from wmspec.write.rows import Row
from wmspec.write.words import human, reading

Record = dict[str, Any]

#: Puts a picture (PNG) where the page finds it, under a task's name, and says where that is.
Put = Callable[[str, bytes], str]


def about(dataset: DatasetReader) -> Record:
    """What the page says of the dataset and of its tasks."""
    manifest = dataset.manifest
    return {
        "name": dataset.folder.resolve().name,
        "engines": list(dataset.engines),
        "rows": manifest["rows"],
        "seed": manifest["seed"],
        "size": manifest["size"],
        "versions": manifest["versions"],
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


def records(dataset: DatasetReader, per_task: int, put: Put) -> Iterator[Record]:
    """The records of at most `per_task` instances of each task, spread over those that were kept."""
    for task in dataset.tasks:
        units = dataset.units(task)
        kept = sorted({row["index"] for row in dataset.rows(task, ["index"])})
        shown = min(per_task, len(kept))
        chosen = {kept[i * len(kept) // shown] for i in range(shown)}
        rows = sorted(dataset.rows(task, only=chosen), key=lambda r: (r["index"], r["question"]))
        for _, same in groupby(rows, key=lambda r: (r["index"], r["question"])):
            yield _record(list(same), units, dataset.engines, put)


def _record(rows: list[Row], units: dict[str, str], engines: tuple[str, ...], put: Put) -> Record:
    first = rows[0]
    return {
        "id": f"{first['task']}/{first['index']}" + (f"/q{first['question']}" if first["question"] else ""),
        "task": first["task"],
        "index": first["index"],
        "factors": _varied(first, "factor", units),
        "nuisances": _varied(first, "nuisance", units),
        "difference": _difference(first),
        "answer": _answer(first),
        "agreement": _agreement(rows),
        "runs": [_run(row, put) for row in sorted(rows, key=lambda r: engines.index(r["engine"]))],
    }


def _varied(row: Row, sort: str, units: dict[str, str]) -> dict[str, str]:
    return {k.partition(".")[2]: human(v, units.get(k, "")) for k, v in row.items() if k.startswith(f"{sort}.")}


def _difference(row: Row) -> str | None:
    """How strong the stimulus is, where the row says so."""
    difference = row.get("difference")
    return f"{difference['name']}: {human(difference['value'], difference['unit'])}" if difference else None


def _answer(row: Row) -> str:
    """What one filters by: the true words, or the place of the true picture."""
    return f"picture {'ABCDEFGHIJKLMNOPQRSTUVWXYZ'[row['answer']]}" if row["option_image"] else str(row["answer_value"])


def _agreement(rows: list[Row]) -> str:
    """Whether the outcomes of all engines pick the same option."""
    votes = [(row, vote) for row in rows for vote in row["agreement"]]
    if len({vote["engine"] for _, vote in votes}) < 2:
        return "one engine"
    agree = all(v["answer"] == row["answer"] and not v.get("rejected") for row, v in votes)
    return "all agree" if agree else "some differ"


def _run(row: Row, put: Put) -> Record:
    """What one engine makes of it."""
    looks = zip(row["context"], row["context_camera"], row["context_time"], strict=True)
    return {
        "engine": row["engine"],
        "renderer": row["renderer"],
        "text": row["text"],
        "context": [{"src": put(row["task"], p["bytes"]), "camera": c, "time": f"{t:.3g} s"} for p, c, t in looks],
        "options": _options(row, put),
        "true": row["answer"],
        "value": row["answer_value"],
        "measured": [[m["name"], reading(m["name"], m["value"])] for m in row["measured"]],
        "margin": None if row["margin"] is None else f"{row['margin']:.2g}",
        "votes": [[v["engine"], v["answer"], v.get("rejected")] for v in row["agreement"]],
    }


def _options(row: Row, put: Put) -> list[Record]:
    shown = [put(row["task"], p["bytes"]) for p in row["option_image"]] or row["option_text"] or []
    key = "src" if row["option_image"] else "text"
    kinds, names, changes = row["option_kind"], row["option_name"], row["option_change"]
    return [
        {key: what, "kind": kind, "name": name, "change": change}
        for what, kind, name, change in zip(shown, kinds, names, changes, strict=True)
    ]
