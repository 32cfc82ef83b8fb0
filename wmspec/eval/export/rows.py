"""Exported questions: complete requests, made by a prompt template, as rows that do not depend on wmspec."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from wmspec.core.diagnostics import WmsError
from wmspec.core.safe_io import make_folders
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval.models.prompt import Prompt
from wmspec.eval.models.question import Question, questions
from wmspec.eval.models.request import Ask, Clip, Picture, Text

Row = dict[str, Any]

_IMAGES = pa.list_(pa.struct([("bytes", pa.binary()), ("path", pa.string())]))
_CONTENT = pa.list_(pa.struct([("text", pa.string()), ("image", pa.int64())]))

#: The columns of exported questions: type and description.
COLUMNS: dict[str, tuple[pa.DataType, str]] = {
    "id": (pa.string(), "the question's id"),
    "task": (pa.string(), "the task"),
    "dimension": (pa.string(), "what is tested, from broad to narrow"),
    "question_name": (pa.string(), "the question's name; empty if it has none"),
    "engine": (pa.string(), "who executed the episode"),
    "group": (pa.string(), "the control group: questions of a group are not independent"),
    "question": (pa.string(), "the question alone"),
    "system": (pa.string(), "the system's words"),
    "content": (_CONTENT, "what is sent, in order: each a text, or the place of a picture in `images`"),
    "images": (_IMAGES, "the pictures"),
    "options": (pa.list_(pa.string()), "the words of the options, null for a picture; empty for an open question"),
    "labels": (pa.string(), "what the options are called by: letters or numbers"),
    "answer": (pa.int64(), "the place of the true option; null for an open question"),
    "answer_number": (pa.float64(), "of an open question: the true number"),
    "answer_unit": (pa.string(), "its SI unit"),
    "answer_within": (pa.float64(), "the largest error of a right number"),
}

# `datasets` before version 4 does not know "List"; later versions read both.
_FEATURES = b'{"info": {"features": {"images": {"_type": "Sequence", "feature": {"_type": "Image"}}}}}'
SCHEMA = pa.schema([pa.field(n, kind) for n, (kind, _) in COLUMNS.items()], metadata={"huggingface": _FEATURES})

#: Rows in a row group; small, so that single rows are read quickly.
_GROUP = 64


def exported_rows(dataset: DatasetReader, ids: Collection[str], prompt: Prompt) -> Iterator[Row]:
    """Yield the rows of questions, few in memory at a time. Raises WmsError for a prompt with videos."""
    return (exported_row(question, prompt) for question in questions(dataset, ids))


def exported_row(question: Question, prompt: Prompt) -> Row:
    """Return the row of a question. Raises WmsError for a prompt with videos."""
    ask = Ask(question, prompt)
    content: list[Row] = []
    images: list[Row] = []
    for part in ask.request.parts:
        match part:
            case Text(text):
                content.append({"text": text, "image": None})
            case Picture(png):
                content.append({"text": None, "image": len(images)})
                images.append({"bytes": png, "path": None})
            case Clip():
                raise WmsError("videos cannot be exported; use another --prompt than `clip`")
    number, unit, within = question.open_answer
    return {
        "id": question.id,
        "task": question.task,
        "dimension": question.dimension,
        "question_name": question.name,
        "engine": question.engine,
        "group": question.group,
        "question": question.text,
        "system": prompt.system,
        "content": content,
        "images": images,
        "options": list(question.options),
        "labels": ask.labels,
        "answer": question.answer,
        "answer_number": number,
        "answer_unit": unit,
        "answer_within": within,
    }


def write(path: Path, rows: Iterable[Row]) -> int:
    """Write rows as Parquet; returns their number. Raises OSError if that fails."""
    make_folders(path.parent)
    left, count = iter(rows), 0
    with pq.ParquetWriter(path, SCHEMA, compression="zstd") as file:
        while batch := list(islice(left, _GROUP)):
            file.write_table(pa.Table.from_pylist(batch, schema=SCHEMA))
            count += len(batch)
    return count
