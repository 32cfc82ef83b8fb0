"""Results: one row a reply in Parquet, with the settings in a JSON file. They can be scored again from the texts."""

from __future__ import annotations

import json
import os
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, get_args

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from wmspec.core.diagnostics import WmsError
from wmspec.core.parquet_io import read_table
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import is_file_name, make_folders, read_bytes
from wmspec.dataset.build.files import with_remedies
from wmspec.eval import replies
from wmspec.eval.models.chance import chances
from wmspec.eval.models.journal import Replies
from wmspec.eval.models.model import Reply
from wmspec.eval.models.question import Question
from wmspec.eval.models.request import Ask
from wmspec.eval.replies import Outcome

Row = dict[str, Any]

#: The columns of results: type and description.
COLUMNS: dict[str, tuple[pa.DataType, str]] = {
    "id": (pa.string(), "the question's id in the dataset"),
    "task": (pa.string(), "the task"),
    "dimension": (pa.string(), "what is tested, from broad to narrow"),
    "question_name": (pa.string(), "the question's name; empty if it has none"),
    "engine": (pa.string(), "who executed the episode"),
    "index": (pa.int64(), "which instance of the task's design"),
    "block": (pa.int64(), "which repetition of the design"),
    "group": (pa.string(), "the control group, which is resampled as a whole for intervals"),
    "model": (pa.string(), "the model as it was named"),
    "model_version": (pa.string(), "the model as it names itself"),
    "prompt": (pa.string(), "the prompt's name"),
    "prompt_hash": (pa.string(), "depends on everything in the template"),
    "ablation": (pa.string(), "what `--ablate` left out or changed; null: nothing"),
    "permutation": (pa.int64(), "the circular shift of the options, in positions"),
    "sample": (pa.int64(), "which of several replies to the same request"),
    "order": (pa.list_(pa.int64()), "the places of the options in the dataset, in the order in which they were shown"),
    "labels": (pa.string(), "the labels of the options: letters or numbers; words if the options were not shown"),
    "options": (pa.list_(pa.string()), "the words of the options in the dataset's order, null for a picture"),
    "answer": (pa.int64(), "the place of the true option in the dataset; null for an open question"),
    "answer_number": (pa.float64(), "of an open question: the true number"),
    "answer_unit": (pa.string(), "its SI unit"),
    "answer_within": (pa.float64(), "the largest error of a right number"),
    "text": (pa.string(), "the reply as it came"),
    "parsed": (pa.int64(), "the place in the dataset of the option chosen; null if none could be read"),
    "number": (pa.float64(), "of an open question: the number given"),
    "right": (pa.bool_(), "whether the reply is right; false if it could not be read, was refused or failed"),
    "status": (
        pa.string(),
        "answered, unparsed, truncated (by the limit of tokens), refused (by a filter) or error (no reply)",
    ),
    "finish_reason": (pa.string(), "why the model stopped, in the words of the server"),
    "reasoning": (pa.string(), "the reasoning, if the server returned it separately"),
    "error": (pa.string(), "why no reply came, or what a filter said"),
    "tokens_in": (pa.int64(), "tokens sent"),
    "tokens_out": (pa.int64(), "tokens received"),
    "tokens_reasoning": (pa.int64(), "tokens of reasoning among those received"),
    "cost": (pa.float64(), "what it cost, in the currency of the prices"),
    "seconds": (pa.float64(), "from first request to reply, retries included"),
}
SCHEMA = pa.schema([pa.field(name, kind) for name, (kind, _) in COLUMNS.items()])
_ABOUT = b"wmspec"
#: The fields of a reply that are columns of the same names; `finish` is `finish_reason` there.
_OF_REPLY = tuple(field.name for field in fields(Reply) if field.name != "finish")


@dataclass(frozen=True)
class Counts:
    """Counts of a run: replies by status, right ones, and the accuracy of guessing (None if unknown)."""

    replies: int
    right: int
    status: dict[str, int]
    chance: float | None
    tokens_in: int
    tokens_out: int
    cost: float | None


def row(ask: Ask, reply: Reply, model: str, prompt: str) -> Row:
    """Return the scored row of a reply."""
    question: Question = ask.question
    number, unit, within = question.open_answer
    return score(
        {
            **question.columns,
            "model": model,
            "prompt": prompt,
            "prompt_hash": ask.prompt.hash,
            "ablation": ask.ablation,
            "permutation": ask.permutation,
            "sample": ask.sample,
            "order": list(ask.order),
            "labels": ask.labels,
            "options": list(ask.words),
            "answer": question.answer,
            "answer_number": number,
            "answer_unit": unit,
            "answer_within": within,
            **{name: getattr(reply, name) for name in _OF_REPLY},
            "status": "error" if reply.failed else "answered",
            "finish_reason": reply.finish,
        }
    )


def score(row: Row) -> Row:
    """Return a row with `parsed`, `number`, `right` and `status` computed from its text and other columns."""
    order = row["order"]
    shown = row | {
        "options": [row["options"][place] for place in order],
        "answer": order.index(row["answer"]) if row["answer"] is not None else None,
    }
    mark = replies.mark_row(row["text"], shown, row["finish_reason"])
    came = row["status"] != "error"
    return {
        **row,
        "parsed": order[mark.place] if came and mark.place is not None else None,
        "number": mark.number if came else None,
        "right": came and mark.right,
        "status": mark.outcome if came else "error",
    }


def counts(rows: Sequence[Row]) -> Counts:
    """Return the counts of rows."""
    shares = chances({**row, "options": len(row["options"])} for row in rows)
    known = [share for share in shares if share is not None]
    costs = [row["cost"] for row in rows if row["cost"] is not None]
    return Counts(
        replies=len(rows),
        right=sum(row["right"] for row in rows),
        status=dict(sorted(Counter(row["status"] for row in rows).items())),
        chance=sum(known) / len(rows) if rows and len(known) == len(rows) else None,
        tokens_in=sum(row["tokens_in"] or 0 for row in rows),
        tokens_out=sum(row["tokens_out"] or 0 for row in rows),
        cost=sum(costs) if costs else None,
    )


# ---------------------------------------------------------------- files


def files_of(paths: Sequence[Path]) -> list[Path]:
    """Return result files, and those in folders, each once. Raises WmsError for a folder without any."""
    files: list[Path] = []
    for path in paths:
        below = sorted(path.rglob("*.parquet")) if path.is_dir() else [path]
        if not below:
            raise WmsError(f"{path} holds no results; `wmspec evaluate` writes them as .parquet files")
        files += below
    return list(dict.fromkeys(files))


def settings_path(path: Path) -> Path:
    """Return the path of the settings file of results."""
    return path.with_suffix(".json")


def check_free(path: Path) -> None:
    """Raise WmsError if a foreign file is in the way of the settings file."""
    beside = settings_path(path)
    try:
        ours = "asked" in json.loads(read_bytes(beside))
    except FileNotFoundError:
        return
    except (OSError, ValueError, TypeError, RecursionError):
        ours = False
    if not ours:
        message = "it is in the way of the settings file of the results"
        raise WmsError(message, FilePlace(str(beside)), "choose another name with -o")


def write(path: Path, rows: Iterable[Row], about: dict[str, Any], schema: pa.Schema = SCHEMA) -> None:
    """Write results with their settings. Raises WmsError, and leaves the previous files, if that fails."""
    metadata = json.dumps(about, indent=1, ensure_ascii=False) + "\n"
    table = pa.Table.from_pylist(list(rows), schema=schema).replace_schema_metadata({_ABOUT: metadata})
    sink = pa.BufferOutputStream()
    pq.write_table(table, sink, compression="zstd")
    write_atomically(settings_path(path), metadata.encode())
    write_atomically(path, bytes(sink.getvalue()))


def write_atomically(path: Path, content: bytes) -> None:
    """Write a file under a temporary name that is then renamed. Raises WmsError if that fails."""
    part = path.with_name(f"{path.name}.part")
    with with_remedies(path):
        make_folders(path.parent)
        with part.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)


def read(path: Path) -> tuple[list[Row], dict[str, Any]]:
    """Return the rows and settings of results. Raises WmsError if the file is not one of results."""
    try:
        table = read_table(path)
        about = json.loads((table.schema.metadata or {})[_ABOUT])
    except (OSError, pa.ArrowException, KeyError, ValueError, RecursionError):
        raise WmsError(f"{path} holds no results; they are made with `wmspec evaluate DATASET -o {path}`") from None
    table = upgraded(table)
    if not set(SCHEMA.names) <= set(table.column_names) or not isinstance(about, dict):
        raise WmsError(
            "results of another version of wmspec", FilePlace(str(path)), "evaluate again, into another file"
        )
    return validated(table, path).to_pylist(), about


def upgraded(table: pa.Table) -> pa.Table:
    """Return a table of results of an earlier version with the columns and outcomes of this one."""
    if "status" not in table.column_names or "finish_reason" in table.column_names:
        return table
    status = table["status"].combine_chunks()
    refused = pc.equal(status, "refused")
    table = table.set_column(
        table.column_names.index("status"), "status", pc.if_else(pc.equal(status, "ok"), "answered", status)
    )
    filtered = pc.if_else(refused, "content_filter", pa.scalar(None, pa.string()))
    table = table.append_column("finish_reason", filtered)
    for name in ("reasoning", "tokens_reasoning"):
        table = table.append_column(name, pa.nulls(len(table), SCHEMA.field(name).type))
    return table


#: Columns with a value in every row; columns of names; columns of text that is displayed.
_REQUIRED = ("id", "task", "dimension", "engine", "index", "group", "model", "prompt", "permutation", "sample", "order",
           "labels", "options", "text", "right", "status")  # fmt: skip
_NAMES = ("task", "engine")
_DISPLAYED = ("id", "dimension", "question_name", "group", "model", "prompt", "ablation")
_WORDS = re.compile(r"[^\x00-\x1f\x7f-\x9f\u2028\u2029]{0,300}")


def validated(table: pa.Table, path: Path) -> pa.Table:
    """Return the result columns of a table, each with its type. Raises WmsError for an invalid row."""
    known = [name for name in SCHEMA.names if name in table.column_names]
    try:
        table = table.select(known).cast(pa.schema([SCHEMA.field(name) for name in known]))
        fault = _fault(table)
    except (pa.ArrowException, ValueError, KeyError) as error:
        fault = str(error).splitlines()[0][:200]
    if fault:
        raise WmsError(f"no results of wmspec: {fault}", FilePlace(str(path)), "evaluate again, into another file")
    return table


def _fault(table: pa.Table) -> str:
    """Return the first problem of rows with the right types, or ''."""
    for name in _REQUIRED:
        if name in table.column_names and table[name].null_count:
            return f"row {pc.index(pc.is_null(table[name]), True).as_py() + 1}: `{name}` is null"
    for name in (*_NAMES, *_DISPLAYED):
        for word in table[name].unique().to_pylist() if name in table.column_names else ():
            if word is not None and not (is_file_name(word) if name in _NAMES else _WORDS.fullmatch(word)):
                return f"`{name}` is {word[:80]!r}, which is not a name"
    if unknown := set(table["status"].unique().to_pylist()) - set(get_args(Outcome)):
        return f"a status is {min(unknown)[:80]!r}"
    options = "options" if "options" in table.column_names else "order"
    chosen = (table[name].to_pylist() for name in ("order", options, "answer", "parsed"))
    for number, (order, words, *places) in enumerate(zip(*chosen, strict=True), 1):
        known = range(len(words))
        if None in order or sorted(order) != list(known) or not all(p is None or p in known for p in places):
            return f"row {number}: it is of other options than its `order`, {order}"
    return ""


def replies_of(rows: Iterable[Row]) -> Replies:
    """Return the replies of rows."""
    return {(row["id"], row["permutation"], row["sample"]): _reply(row) for row in rows}


def _reply(row: Row) -> Reply:
    return Reply(finish=row["finish_reason"], **{name: row[name] for name in _OF_REPLY})


def rescore(path: Path) -> tuple[Counts, int]:
    """Score results again from their texts, in place. Returns the counts and the number of changed scores."""
    rows, about = read(path)
    again = [score(row) for row in rows]
    write(path, again, about | {"parser": replies.PARSER_VERSION, "right": sum(row["right"] for row in again)})
    return counts(again), sum(before["right"] != after["right"] for before, after in zip(rows, again, strict=True))
