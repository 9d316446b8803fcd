"""One calibration of a Parquet file that is longer than memory: by ``ironout.moments`` and by DataFusion's ``mag_fit``.

    python parquet_sums.py [ROWS] [FOLDER]

Writes a simulated file of so many rows of 16-bit counts, and prints for each way the rate and by how much the resident memory of its
process rises, beside reading the same columns alone. Each way runs in a process of its own. The results must be equal bit for bit.
"""

from __future__ import annotations

import json
import pathlib
import subprocess
import sys
import tempfile
import time

COUNTS = ("mx_counts", "my_counts", "mz_counts")
SCALE_UT = 0.1
BATCH = 1_000_000


def write(path: pathlib.Path, rows: int) -> None:
    """Directions all round, an offset, and noise that differs from batch to batch."""
    import numpy as np
    import pyarrow as arrow
    import pyarrow.parquet as parquet

    rng = np.random.default_rng(1)
    schema = arrow.schema([(name, arrow.int16()) for name in COUNTS])
    with parquet.ParquetWriter(path, schema) as writer:
        for begin in range(0, rows, BATCH):
            n = min(BATCH, rows - begin)
            ball = rng.standard_normal((n, 3), dtype=np.float32)
            ball *= 480 / np.linalg.norm(ball, axis=1)[:, None]
            counts = np.round(ball + [30, -50, 10] + 2.5 * rng.standard_normal((n, 3), dtype=np.float32)).astype(np.int16)
            writer.write_table(arrow.table(dict(zip(COUNTS, counts.T)), schema=schema), row_group_size=BATCH)


def read(path: str) -> dict:
    """Reading alone, as ``moments`` reads."""
    import pyarrow.parquet as parquet

    file = parquet.ParquetFile(path, buffer_size=1 << 20, pre_buffer=False)
    batches = file.iter_batches(batch_size=1 << 18, columns=list(COUNTS), use_threads=False)
    return {"samples": sum(batch.num_rows for batch in batches)}


def moments(path: str) -> dict:
    """The sums, batch by batch."""
    import ironout

    sums = ironout.moments(path)
    fit = json.loads(sums.fit_json((SCALE_UT,) * 3))
    return {"samples": sums.count, **{key: fit[key] for key in ("offset_ut", "matrix", "field_ut")}}


def query(path: str) -> dict:
    """The aggregate of SQL, on one partition per processor."""
    import datafusion
    import ironout.datafusion

    context = datafusion.SessionContext()
    context.register_parquet("log", path)
    context.register_udaf(ironout.datafusion.mag_fit(SCALE_UT))
    (row,) = context.sql(f"SELECT mag_fit({', '.join(COUNTS)}) AS fit FROM log").to_pylist()
    return {key: row["fit"][key] for key in ("samples", "offset_ut", "matrix", "field_ut")}


WAYS = {"read": read, "moments": moments, "query": query}


def resident_mb(field: str) -> float:
    """``VmRSS`` or ``VmHWM`` of this process, where there is /proc."""
    status = pathlib.Path("/proc/self/status")
    lines = status.read_text().splitlines() if status.exists() else []
    return next((int(line.split()[1]) / 1e3 for line in lines if line.startswith(field)), float("nan"))


def one(way: str, path: str) -> None:
    """Runs one way and prints what it gave and took."""
    import ironout
    import pyarrow.parquet

    assert ironout and pyarrow.parquet
    if way == "query":
        import ironout.datafusion
    before, start, cpu = resident_mb("VmRSS"), time.perf_counter(), time.process_time()
    result = WAYS[way](path)
    took = {"s": time.perf_counter() - start, "cpu_s": time.process_time() - cpu, "mb": resident_mb("VmHWM") - before}
    print(json.dumps({"result": result, **took}))


def main(rows: int, folder: pathlib.Path) -> None:
    path = folder / "long.parquet"
    if not path.exists():
        write(path, rows)
    print(f"{rows} rows, {path.stat().st_size / 1e6:.0f} MB")
    results = {}
    for way in WAYS:
        command = [sys.executable, __file__, "--one", way, str(path)]
        said = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        results[way] = said["result"]
        assert said["result"]["samples"] == rows, said
        print(
            f"{way:8} {said['s']:7.2f} s, processor {said['cpu_s']:7.2f} s, {rows / said['cpu_s'] / 1e6:6.1f} million rows per second of "
            f"processor, {said['mb']:5.0f} MB more than at the start"
        )
    assert results["moments"] == results["query"], results
    print(f"both ways: offset {results['query']['offset_ut']} µT, bit for bit the same")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        one(sys.argv[2], sys.argv[3])
    else:
        count = int(float(sys.argv[1])) if len(sys.argv) > 1 else 2_000_000
        if len(sys.argv) > 2:
            main(count, pathlib.Path(sys.argv[2]))
        else:
            with tempfile.TemporaryDirectory() as temporary:
                main(count, pathlib.Path(temporary))
