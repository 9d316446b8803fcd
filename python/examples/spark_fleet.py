"""A fleet and a log in parts with Spark (``pip install pyspark``, and Java 17 or later).

    python spark_fleet.py [FOLDER]

1. ``applyInPandas``: one row per log, equal to the table of one process.
2. ``mapInPandas``: each partition of a long log gives its exact integer sums, which merge to those of the whole, bit for bit.

Without Java or pyspark it says so and ends with status 77.
"""

from __future__ import annotations

import importlib.util
import os
import pathlib
import shutil
import sys
import tempfile
from typing import Any, Iterator

import ironout

COUNTS = ("mx_counts", "my_counts", "mz_counts")
SCALE_UT = (0.1, 0.1, 0.1)
VEHICLES = 3
FLIGHTS = 2
ROW = "vehicle string, log string, verdict string, missing string, offset_x_ut double, rms_ut double"
NOT_RUN = 77


def row(frame: Any) -> Any:
    """One log, as a frame of pandas, as one row of the fleet's table."""
    import pandas

    keys = {name: frame[name].iloc[0] for name in ("vehicle", "log")}
    # Spark does not keep the order of rows in a group.
    columns = frame.drop(columns=list(keys)).sort_values("t_s")
    diagnosis = ironout.diagnose(ironout.read(columns))
    base = diagnosis.data["base"] or {}
    offset = base.get("offset_ut") or [None]
    found = {"verdict": diagnosis.verdict, "missing": " ".join(diagnosis.missing)}
    return pandas.DataFrame([{**keys, **found, "offset_x_ut": offset[0], "rms_ut": base.get("rms_ut")}])


def sums(frames: Iterator[Any]) -> Iterator[Any]:
    """The sums of one partition, as 35 integers in text."""
    import numpy as np
    import pandas

    total = ironout.Moments()
    for frame in frames:
        total = total + ironout.Moments(np.ascontiguousarray(frame[list(COUNTS)].to_numpy(dtype=np.int16)))
    yield pandas.DataFrame({"sums": [total.sums()]})


def make(folder: pathlib.Path) -> tuple[list[Any], ironout.Moments]:
    """Simulated flights in one table, and a long log of counts."""
    import numpy as np
    import pyarrow as arrow
    import pyarrow.parquet as parquet

    frames, tables = [], []
    for vehicle in range(VEHICLES):
        for flight in range(FLIGHTS):
            effects = ["offset:current_a=5"] if vehicle == 1 else []
            frame = ironout.simulate(seed=vehicle + 1, recording=flight + 1, seconds=40, effects=effects).to_frame()
            frame.insert(0, "vehicle", f"v{vehicle}")
            frame.insert(1, "log", f"v{vehicle}_{flight}")
            frames.append(frame)
            tables.append(arrow.Table.from_pandas(frame, preserve_index=False))
    parquet.write_table(arrow.concat_tables(tables), folder / "fleet.parquet", row_group_size=1500)
    counts = np.round(ironout.simulate(seed=9, seconds=300).mag / SCALE_UT[0]).astype(np.int16)
    parquet.write_table(arrow.table(dict(zip(COUNTS, counts.T))), folder / "long.parquet", row_group_size=1000)
    return frames, ironout.Moments(counts)


def main(folder: pathlib.Path) -> None:
    from pyspark.sql import SparkSession

    # The workers run the interpreter that has ironout.
    os.environ.setdefault("PYSPARK_PYTHON", sys.executable)
    frames, whole = make(folder)
    builder = SparkSession.builder.master("local[2]").appName("ironout").config("spark.ui.enabled", "false")
    spark = builder.config("spark.sql.shuffle.partitions", "4").config("spark.driver.host", "127.0.0.1").getOrCreate()
    try:
        logs = spark.read.parquet(str(folder / "fleet.parquet"))
        table = sorted(tuple(one) for one in logs.groupBy("vehicle", "log").applyInPandas(row, ROW).collect())
        alone = sorted(tuple(row(frame).iloc[0]) for frame in frames)
        assert table == alone, (table, alone)
        print(f"{len(table)} logs: {sorted(one[2] for one in table)}; equal to the table of one process")

        long = spark.read.parquet(str(folder / "long.parquet")).repartition(7)
        parts = long.mapInPandas(sums, "sums array<string>").collect()
        merged = ironout.Moments()
        for part in parts:
            merged = merged + ironout.Moments.from_sums(list(part["sums"]))
        assert merged == whole and merged.fit_json(SCALE_UT) == whole.fit_json(SCALE_UT)
        print(f"{len(parts)} partitions, {merged.count} samples: the calibration equals that of the whole log bit for bit")
    finally:
        spark.stop()


if __name__ == "__main__":
    lacking = [name for name, there in (("java", shutil.which("java")), ("pyspark", importlib.util.find_spec("pyspark"))) if not there]
    if lacking:
        print(f"not run: {' and '.join(lacking)} not found")
        sys.exit(NOT_RUN)
    if len(sys.argv) > 1:
        main(pathlib.Path(sys.argv[1]))
    else:
        with tempfile.TemporaryDirectory() as temporary:
            main(pathlib.Path(temporary))
