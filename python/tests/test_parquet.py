"""Parquet and Feather files of other writers: the program reads from them what Python reads."""

from __future__ import annotations

import numpy as np
import pytest

import ironout
from conftest import without_names

pandas = pytest.importorskip("pandas")
arrow = pytest.importorskip("pyarrow")
feather = pytest.importorskip("pyarrow.feather")
parquet = pytest.importorskip("pyarrow.parquet")


@pytest.mark.parametrize("compression", ["none", "snappy", "gzip", "zstd", "lz4"])
def test_parquet_of_pyarrow(compression, program, clean, tmp_path):
    path = tmp_path / "log.parquet"
    parquet.write_table(arrow.table(clean.to_dict()), path, compression=compression, row_group_size=300)
    assert without_names(program("fit", path)) == without_names(ironout.fit(path).data)


@pytest.mark.parametrize("compression", ["uncompressed", "lz4", "zstd"])
def test_feather_of_pyarrow(compression, program, clean, tmp_path):
    path = tmp_path / "log.feather"
    feather.write_feather(arrow.table(clean.to_dict()), path, compression=compression, chunksize=300)
    assert without_names(program("fit", path)) == without_names(ironout.fit(path).data)


def test_parquet_of_polars_and_pandas(program, hidden, tmp_path):
    polars = pytest.importorskip("polars")
    path = tmp_path / "polars.parquet"
    polars.DataFrame(hidden.to_dict()).write_parquet(path)
    told = program("diagnose", path)
    assert told["verdict"] == "missing" and without_names(told) == without_names(ironout.diagnose(path).data)
    frame = hidden.to_frame()
    frame["t_s"] = pandas.to_datetime(1_780_000_000 + frame["t_s"], unit="s", utc=True)
    frame["phase"] = pandas.Categorical(["taxi", "cruise"] * (len(frame) // 2) + ["taxi"] * (len(frame) % 2))
    frame.loc[5, "temp_c"] = None
    path = tmp_path / "pandas.parquet"
    frame.to_parquet(path)
    with pytest.warns(ironout.IronoutWarning, match="phase does not contain numbers"):
        own = ironout.fit(path, add="offset:current_a")
    told = program("fit", path, "--add", "offset:current_a")
    assert without_names(told) == without_names(own.data)


def test_what_is_not_read_is_named_with_a_remedy(program, clean, tmp_path):
    path = tmp_path / "log.parquet"
    parquet.write_table(arrow.table({"t_s": clean.t, "mag": list(clean.mag)}), path)
    message = program("fit", path, status=2)["error"]["message"]
    assert "column mag: each cell is a list. Fix: write its numbers as columns of their own" in message
    parquet.write_table(arrow.table(clean.to_dict()), path, compression="brotli")
    message = program("fit", path, status=2)["error"]["message"]
    assert "compression that is not supported. Fix: write it with snappy" in message
    path.write_bytes(b"FEA1" + bytes(100))
    assert "Feather file of version 1" in program("fit", path, status=2)["error"]["message"]


def test_the_table_of_batch_is_one_that_pandas_reads(program, clean_file, tmp_path):
    (tmp_path / "broken.csv").write_text("t_s,mx_ut\n0,1\n")
    table, lines = tmp_path / "fleet.parquet", tmp_path / "fleet.csv"
    for output in (table, lines):
        program("batch", clean_file, tmp_path / "broken.csv", "-o", output)
    frame, text = pandas.read_parquet(table), pandas.read_csv(lines)
    assert list(frame.columns) == list(text.columns) and len(frame) == 2
    (own,) = frame[frame.verdict != "error"].to_dict("records")
    assert own["offset_x_ut"] == ironout.fit(clean_file).offset_ut[0]
    assert np.array_equal(frame["rms_ut"], text["rms_ut"], equal_nan=True)
    assert frame["rows"].dtype.kind in "uif" and frame["error"].notna().sum() == 1
