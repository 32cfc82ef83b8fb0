"""Croissant metadata (https://docs.mlcommons.org/croissant/docs/croissant-spec-1.0.html) of a dataset."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pyarrow as pa

from wmspec.dataset.build.columns import description
from wmspec.dataset.build.plan import Plan
from wmspec.dataset.build.rows import schema
from wmspec.dataset.build.shards import Record

#: The terms of Croissant used here, in the order of the specification's context.
_TERMS = (
    "citeAs column conformsTo containedIn cr rai data dataType dct examples equivalentProperty extract field "
    "fileProperty fileObject fileSet format includes isLiveDataset jsonPath key md5 parentField path recordSet "
    "references regex repeated replace samplingRate sc separator source subField transform"
)
#: The JSON-LD context of the specification, restricted to these terms. Those that mean something else than their name
#: in `cr` are replaced at their place: the order of the context is part of the bytes of a dataset.
CONTEXT: dict[str, Any] = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    **{term: f"cr:{term}" for term in _TERMS.split()},
    "conformsTo": "dct:conformsTo",
    "cr": "http://mlcommons.org/croissant/",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "dct": "http://purl.org/dc/terms/",
    "examples": {"@id": "cr:examples", "@type": "@json"},
    "sc": "https://schema.org/",
}

_TYPES = {pa.bool_(): "sc:Boolean", pa.int64(): "sc:Integer", pa.float64(): "sc:Float", pa.string(): "sc:Text"}


@dataclass(frozen=True)
class TaskMetadata:
    """A task that has questions: its name, title and columns, and the split of its files."""

    name: str
    title: str
    columns: pa.Schema
    split: str = "test"


def croissant(plan: Plan, records: Mapping[str, Record], cited: str, published: str) -> dict[str, Any]:
    """Return the metadata as JSON values: a file set and a record set for each task that has questions.

    `cited` is the citation (BibTeX), `published` the date (YYYY-MM-DD).
    """
    rows = {t.spec.name: 0 for t in plan.tasks}
    for shard in plan.shards():
        rows[shard.task.spec.name] += records[shard.path].rows
    filled = [
        TaskMetadata(t.spec.name, t.spec.title, schema(t.spec, plan.film is not None), plan.split_name)
        for t in plan.tasks
        if rows[t.spec.name]
    ]
    description = f"{sum(rows.values())} questions about a physical world, made by wmspec"
    licenses = [plan.licence] if plan.licence else sorted({name for t in plan.tasks for name in t.spec.licenses})
    name = "-".join(t.spec.name for t in plan.tasks[:3])
    described = metadata(name, description, f"{plan.record['format']}.0.0", filled, licenses or ["unknown"])
    return described | {"citeAs": cited, "datePublished": published}


def metadata(
    name: str, description: str, version: str, tasks: Sequence[TaskMetadata], licenses: Iterable[str]
) -> dict[str, Any]:
    """Return the metadata of a dataset with the given tasks, as JSON values."""
    described: dict[str, Any] = {
        "@context": CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "name": name or "wmspec",
        "description": description,
        "version": version,
        "distribution": [_files(task.name, task.split) for task in tasks],
        "recordSet": [_records(task) for task in tasks],
    }
    listed = list(licenses)
    return described | {"license": listed} if listed else described


def _files(name: str, split: str) -> dict[str, Any]:
    return {
        "@type": "cr:FileSet",
        "@id": f"files/{name}",
        "name": f"files/{name}",
        "encodingFormat": "application/x-parquet",
        "includes": f"data/{name}/{split}-*.parquet",
    }


def _records(task: TaskMetadata) -> dict[str, Any]:
    name = task.name
    fields = [_field(name, f) for f in task.columns]
    described = {"description": task.title} if task.title else {}
    return {
        "@type": "cr:RecordSet",
        "@id": name,
        "name": name,
        **described,
        "key": {"@id": f"{name}/id"},
        "field": [f for part in fields for f in part],
    }


def _field(task: str, field: pa.Field) -> list[dict[str, Any]]:
    """Return the Croissant fields of a column. A list of structs becomes one field for each member."""
    item = field.type.value_type if pa.types.is_list(field.type) else field.type
    if not pa.types.is_struct(item):
        return [_one(task, field, _TYPES[item])]
    if item.field(0).name == "bytes":
        return [_one(task, field, "sc:ImageObject", "bytes")]
    return [_one(task, field, _TYPES[part.type], part.name, f".{part.name}") for part in item]


def _one(task: str, column: pa.Field, kind: str, part: str = "", named: str = "") -> dict[str, Any]:
    """Return the Croissant field of a column, or of one member of its structs."""
    name = f"{task}/{column.name}{named}"
    field: dict[str, Any] = {"@type": "cr:Field", "@id": name, "name": name, "dataType": kind}
    field["description"] = description(column.name)
    if pa.types.is_list(column.type):
        field["repeated"] = True
    transform = {"transform": {"jsonPath": part}} if part else {}
    return field | {"source": {"fileSet": {"@id": f"files/{task}"}, "extract": {"column": column.name}, **transform}}
