"""Guarded reads of Parquet files, which may unpack to much more than their size."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from wmspec.core.limits import TABLE_ROWS, UNPACKED_BYTES
from wmspec.core.safe_io import regular_file

#: Size (bytes) that a batch of rows may unpack to, and its maximum number of rows.
_BATCH_BYTES, _BATCH_ROWS = 64 << 20, 1024


def open_parquet(path: Path) -> pq.ParquetFile:
    """Open a file. Raises OSError or ArrowException if it is unreadable, irregular or has too many rows."""
    file = pq.ParquetFile(regular_file(path))
    if file.metadata.num_rows > TABLE_ROWS.most:
        raise OSError(f"it {TABLE_ROWS.sentence}")
    return file


def batches(
    file: pq.ParquetFile, columns: Sequence[str] | None = None, groups: Sequence[int] | None = None
) -> Iterator[pa.RecordBatch]:
    """Yield the rows of a file in batches of bounded size. Raises OSError if one row is larger, or ArrowException."""
    chosen = range(file.num_row_groups) if groups is None else groups
    largest = max((_largest_column(file.metadata.row_group(group)) for group in chosen), default=0)
    if largest > UNPACKED_BYTES.most:
        raise OSError(f"a column {UNPACKED_BYTES.sentence}")
    rows = min(_BATCH_ROWS, max(1, _BATCH_BYTES // max(1, largest)))  # each may be as large as the whole column
    for batch in file.iter_batches(rows, chosen, columns, use_threads=False):
        yield _decoded(batch)


def _decoded(batch: pa.RecordBatch) -> pa.RecordBatch:
    """Return a batch without dictionaries, whose size is that of its values."""
    for place, column in enumerate(batch.columns):
        if pa.types.is_dictionary(column.type):
            batch = batch.set_column(place, batch.schema.names[place], column.dictionary_decode())
        elif "dictionary" in str(column.type):
            raise OSError(f"column `{batch.schema.names[place]}` has dictionaries inside lists")
    return batch


def _largest_column(group: pq.RowGroupMetaData) -> int:
    return max((group.column(place).total_uncompressed_size for place in range(group.num_columns)), default=0)


def read_table(path: Path, columns: Sequence[str] | None = None) -> pa.Table:
    """Return a whole file, or some of its columns. Raises OSError as `batches` does, or if it unpacks to too much."""
    file, read, size = open_parquet(path), list[pa.RecordBatch](), 0
    for batch in batches(file, columns):
        size += batch.nbytes
        if size > UNPACKED_BYTES.most:
            raise OSError(f"it {UNPACKED_BYTES.sentence}")
        read.append(batch)
    schema = read[0].schema if read else file.read(columns).schema
    return pa.Table.from_batches(read, schema).replace_schema_metadata(file.schema_arrow.metadata)
