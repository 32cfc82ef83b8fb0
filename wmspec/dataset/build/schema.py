"""Validation of manifests and rows that come from elsewhere."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from typing import Annotated, Any, Literal

import pyarrow as pa
from pydantic import BaseModel, ConfigDict, Field, StringConstraints, ValidationError

from wmspec.core.safe_io import is_file_name
from wmspec.core.signals import defer_signals
from wmspec.dataset.build.columns import COLUMNS, EARLIER_TYPES
from wmspec.dataset.build.film_files import FILM
from wmspec.dataset.build.images import image_format
from wmspec.dataset.build.plan import row_names
from wmspec.dataset.build.rows import Row
from wmspec.runtime.questions.consensus import Consensus, RowsOf

#: The path of a shard, which contains the name of its task.
SHARD = re.compile(r"data/(\w[\w.-]{0,99})/(?:train|validation|test)-\d{5}-of-\d{5}\.parquet")

_Name = Annotated[str, StringConstraints(pattern=r"^\w[\w.-]{0,99}$")]
_Count = Annotated[int, Field(ge=0, strict=True)]
_Side = Annotated[int, Field(ge=1, le=8192, strict=True)]
_Sha256 = Annotated[str, StringConstraints(pattern=r"^[0-9a-f]{64}$")]


class _Strict(BaseModel):
    model_config = ConfigDict(strict=True, defer_build=True)


class _Task(_Strict):
    dimension: str
    title: str
    description: str
    instances: _Count
    selected: _Count | None = None
    rows: dict[_Name, _Count]
    rejected: dict[str, _Count]
    holdouts: list[dict[_Name, bool | float | str | list[float]]] = []
    balance_batches: list[list[_Count]] = []


class _Split(_Strict):
    name: Literal["train", "validation", "test"]
    shares: dict[Literal["train", "validation", "test"], Annotated[int, Field(ge=0, le=100, strict=True)]]


class _Film(_Strict):
    rate: Literal[8, 12, 16, 24, 30, 60]
    size: Annotated[list[_Side], Field(min_length=2, max_length=2)]
    seconds: Annotated[float, Field(gt=0, le=60)] | None = None


class _Shard(_Strict):
    rows: _Count
    sha256: _Sha256
    films: dict[Annotated[str, StringConstraints(pattern=f"^{FILM.pattern}$")], _Sha256] = {}


class _Rejected(_Strict):
    task: _Name
    index: _Count
    question: _Count
    engine: str
    reason: str
    detail: str


class _Rejections(_Strict):
    count: dict[str, _Count]
    list: list[_Rejected]


class _Manifest(_Strict):
    seed: int
    engines: Annotated[list[_Name], Field(min_length=1)]
    size: Annotated[list[_Side], Field(min_length=2, max_length=2)]
    consensus: Consensus
    rows_of: RowsOf = "engines"
    profile: str = ""
    licence: str = ""
    part: Annotated[list[Annotated[int, Field(ge=1, strict=True)]], Field(min_length=2, max_length=2)] = [1, 1]
    film: _Film | None = None
    split: _Split | None = None
    versions: dict[str, str]
    tasks: dict[_Name, _Task]
    rows: _Count
    rejected: _Rejections
    shards: dict[Annotated[str, StringConstraints(pattern=f"^{SHARD.pattern}$")], _Shard]
    files: dict[str, _Sha256] = {}


def manifest_fault(manifest: Any) -> str:
    """Return the first problem of a manifest (JSON values), or ''."""
    try:
        with defer_signals():  # Pydantic takes a signal's exception for a fault of the manifest
            _Manifest.model_validate(manifest)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(map(str, first["loc"]))[:120]
        return f"`{where}`: {first['msg'].lower()}" if where else "it is no object"
    return _counts_fault(manifest)


def _counts_fault(manifest: Any) -> str:
    """Return the first contradiction between the counts of a manifest, or ''."""
    kept = Counter[str]()
    for path, shard in manifest["shards"].items():
        kept[path.split("/")[1]] += shard["rows"]
    for name, task in manifest["tasks"].items():
        if (counted := sum(task["rows"].values())) != kept[name]:
            return f"it counts {counted:,} rows of `{name}`, and {kept[name]:,} in its files"
        known = row_names(manifest.get("rows_of", "engines"), manifest["engines"])
        if unknown := task["rows"].keys() - set(known):
            return f"`{name}` counts rows of {sorted(unknown)[0]}, expected {' or '.join(known)}"
    if unknown := kept.keys() - manifest["tasks"].keys():
        return f"it has files of `{sorted(unknown)[0]}`, which is none of its tasks"
    if manifest["rows"] != kept.total():
        return f"it counts {manifest['rows']:,} rows, and {kept.total():,} in its files"
    lost = Counter(r["reason"] for r in manifest["rejected"]["list"])
    return "" if lost == Counter(manifest["rejected"]["count"]) else "its rejections are not those that it counts"


#: Columns that every Parquet file has, with a value in every row.
_REQUIRED = (
    "id", "task", "dimension", "index", "question", "engine", "renderer", "text", "context", "context_camera",
    "context_time", "option_image", "option_kind", "option_name", "option_change", "measured", "agreement",
)  # fmt: skip
#: List columns whose items may be null.
_NULLABLE_ITEMS = ("option_change",)
#: Groups of lists with equal length.
_EQUAL_LENGTHS = (
    ("context", "context_camera", "context_time"),
    ("option_kind", "option_name", "option_change"),
)


def columns_fault(columns: pa.Schema) -> str:
    """Return the first problem of the columns of a Parquet file, or ''."""
    if twice := [name for name, count in Counter(columns.names).items() if count > 1]:
        return f"it has two columns `{twice[0]}`"
    if missing := [name for name in _REQUIRED if name not in columns.names]:
        return f"it has no column `{missing[0]}`"
    for name, (kind, _) in COLUMNS.items():
        if name in columns.names and (there := columns.field(name).type) not in (kind, *EARLIER_TYPES.get(name, ())):
            return f"column `{name}` is {there}, expected {kind}"
    return ""


def row_fault(row: Row, task: str, engines: Sequence[str]) -> str:
    """Return the first problem of a row of which some columns were read, or ''."""
    for name in _REQUIRED:
        value = row.get(name, "")
        if value is None or (isinstance(value, list) and name not in _NULLABLE_ITEMS and None in value):
            return f"`{name}` is null"
    if null := next(_null_names(row), ""):
        return f"{null} is null"
    for name, known in (("task", [task]), ("engine", engines)):
        if name in row and row[name] not in known:
            return f"its {name} is `{str(row[name])[:60]}`, expected {' or '.join(known)}"
    if "renderer" in row and not is_file_name(row["renderer"]):
        return f"its renderer is `{str(row['renderer'])[:60]}`, which is not a name"
    if "index" in row and not row["index"] >= 0:
        return f"its index is {row['index']}"
    for names in _EQUAL_LENGTHS:
        counts = {name: len(row[name]) for name in names if name in row}
        if len(set(counts.values())) > 1:
            return "it has " + ", ".join(f"{n} {name}" for name, n in counts.items())
    return _options_fault(row)


def _null_names(row: Row) -> Iterator[str]:
    """Yield the names, units, engines and readings that are null in the structures of a row."""
    for name, value in row.items():
        fields = ("name", "unit", "engine", "value") if name == "measured" else ("name", "unit", "engine")
        for item in value if isinstance(value, list) else (value,):
            if isinstance(item, dict):
                yield from (f"`{field}` of `{name}`" for field in fields if field in item and item[field] is None)


def _options_fault(row: Row) -> str:
    """Return the first problem of a row's options, or ''."""
    if not row.keys() >= {"option_text", "option_image", "option_kind", "answer"}:
        return ""
    pictured, texts, kinds = row["option_image"], row["option_text"] or [], row["option_kind"]
    if len(pictured) + len(texts) != len(kinds):
        return f"it has {len(kinds)} options, {len(texts)} with a text and {len(pictured)} with a picture"
    answer = row["answer"]
    if (answer is None) != (not kinds) or (kinds and not 0 <= answer < len(kinds)):
        return f"its answer is {answer}, of {len(kinds)} options"
    return "it has too many options" if len(kinds) > 26 else ""


def pictures_fault(row: Row, names: Iterable[str]) -> str:
    """Return the first problem of a row's pictures that shows without decoding, or ''."""
    for name in names:
        for number, each in enumerate(row.get(name) or ()):
            if not image_format(each.get("bytes")):
                return f"picture {number + 1} of `{name}` is no PNG or WebP"
    return ""
