"""Exact sums of logs that are too long for memory."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Iterable, Sequence, Union

import numpy as np

from ._ironout import IronoutError, Moments

if TYPE_CHECKING:
    import pyarrow

COUNTS = ("mx_counts", "my_counts", "mz_counts")
BATCH_ROWS = 1 << 18

Source = Union[str, "os.PathLike[str]", Iterable[Any]]


def moments(source: Source, columns: Sequence[str] = COUNTS, batch_rows: int = BATCH_ROWS) -> Moments:
    """The sums of 16-bit counts in a Parquet file, or in an iterable of pyarrow batches or tables, batch by batch.

    Memory is that of one batch, however long the log is. ``columns`` are the columns of x, y and z. Rows in which one of the
    three is null are not counted.
    """
    total = Moments()
    for batch in _batches(source, columns, batch_rows):
        total = total + Moments(_triples([batch.column(name) for name in columns], columns))
    return total


def _batches(source: Source, columns: Sequence[str], batch_rows: int) -> Iterable["pyarrow.RecordBatch"]:
    if not isinstance(source, (str, os.PathLike)):
        return source
    from pyarrow import parquet

    # A buffered stream: without it a whole row group of a file is read at once.
    file = parquet.ParquetFile(source, buffer_size=1 << 20, pre_buffer=False)
    missing = [name for name in columns if name not in file.schema_arrow.names]
    if missing:
        names = ", ".join(file.schema_arrow.names)
        raise IronoutError(f"{os.fspath(source)}: there is no column {missing[0]}. Fix: name the columns of x, y and z, of {names}")
    return file.iter_batches(batch_size=batch_rows, columns=list(columns), use_threads=False)


def _triples(columns: Sequence[Any], names: Sequence[str]) -> np.ndarray:
    """Columns of a batch as counts, one row per sample."""
    import pyarrow as arrow
    import pyarrow.compute as compute

    for column, name in zip(columns, names):
        if not arrow.types.is_integer(column.type):
            raise IronoutError(
                f"column {name} is {column.type}: exact sums need the 16-bit counts of the sensor. "
                "Fix: divide by the scale and round, or use fit() for a log in microtesla"
            )
    if any(column.null_count for column in columns):
        valid = compute.and_(compute.and_(*(column.is_valid() for column in columns[:2])), columns[2].is_valid())
        columns = [column.filter(valid) for column in columns]
    out = np.empty((len(columns[0]), 3), dtype=np.int16)
    for axis, (column, name) in enumerate(zip(columns, names)):
        values = column.to_numpy(zero_copy_only=False) if isinstance(column, arrow.Array) else column.to_numpy()
        if values.dtype != np.int16 and len(values) and not (-32768 <= values.min() and values.max() <= 32767):
            raise IronoutError(f"column {name} has counts beyond 16 bits: {values.min()} to {values.max()}")
        out[:, axis] = values
    return out
