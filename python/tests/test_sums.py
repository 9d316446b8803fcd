"""Exact sums of logs that are longer than memory."""

from __future__ import annotations

import json

import ironout
import numpy as np
import pyarrow as arrow
import pyarrow.parquet as parquet
import pytest

NAMES = ("mx_counts", "my_counts", "mz_counts")
SCALE_UT = (0.1, 0.1, 0.1)


@pytest.fixture(scope="module")
def counts():
    return np.round(ironout.simulate(seed=4, seconds=200).mag / 0.1).astype(np.int16)


def table(counts, **more):
    return arrow.table({**dict(zip(NAMES, counts.T)), **more})


def test_a_parquet_file_in_batches_gives_the_sums_of_the_whole(counts, tmp_path):
    path = tmp_path / "log.parquet"
    parquet.write_table(table(counts), path, row_group_size=1000)
    whole = ironout.Moments(counts)
    assert ironout.moments(path) == ironout.moments(str(path), batch_rows=77) == whole
    assert ironout.moments(table(counts).to_batches(max_chunksize=300)) == whole


def test_rows_with_a_null_are_not_counted():
    columns = [[1, 2, None, 4], [5, 6, 7, 8], [9, None, 11, -12]]
    one = arrow.table({name: arrow.array(values, arrow.int32()) for name, values in zip(NAMES, columns)})
    assert ironout.moments([one]) == ironout.Moments(np.array([[1, 5, 9], [4, 8, -12]], dtype=np.int16))


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ({"a": [1], "b": [2]}, "there is no column mx_counts. Fix: name the columns of x, y and z, of a, b"),
        ({name: [0.5] for name in NAMES}, "column mx_counts is double"),
        ({name: [40_000] for name in NAMES}, "counts beyond 16 bits: 40000"),
    ],
)
def test_what_is_no_count_is_refused_with_its_column(columns, words, tmp_path):
    path = tmp_path / "log.parquet"
    parquet.write_table(arrow.table(columns), path)
    with pytest.raises(ironout.IronoutError, match=words):
        ironout.moments(path)


def test_mag_fit_of_sql_is_the_fit_of_the_sums_bit_for_bit(counts, tmp_path):
    datafusion = pytest.importorskip("datafusion")
    import ironout.datafusion

    vehicle = np.arange(len(counts)) % 2
    path = tmp_path / "log.parquet"
    parquet.write_table(table(counts, vehicle=vehicle), path, row_group_size=700)
    context = datafusion.SessionContext()
    context.register_parquet("log", str(path))
    context.register_udaf(ironout.datafusion.mag_fit(0.1))
    call = f"mag_fit({', '.join(NAMES)})"
    rows = context.sql(f"SELECT vehicle, {call} AS fit FROM log GROUP BY vehicle ORDER BY vehicle").to_pylist()
    assert [row["vehicle"] for row in rows] == [0, 1]
    for row in rows:
        own = json.loads(ironout.Moments(counts[vehicle == row["vehicle"]]).fit_json(SCALE_UT))
        assert {key: row["fit"][key] for key in ("offset_ut", "matrix", "field_ut", "rms_ut")} == {
            key: own[key] for key in ("offset_ut", "matrix", "field_ut", "rms_ut")
        }
    (none,) = context.sql(f"SELECT {call} AS fit FROM log WHERE vehicle = 5").to_pylist()
    assert none["fit"]["samples"] == 0 and "hardly moved" in none["fit"]["refused"]
