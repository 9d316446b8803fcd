"""A fleet and a log in parts on several processes with Dask.

    python dask_fleet.py [FOLDER]

1. The table of a fleet: one task per log, equal to the table of one process.
2. One calibration of a log in many Parquet parts: each part gives its exact integer sums, the sums merge in any order, and the
   calibration equals that of the whole log bit for bit. A worker is killed meanwhile, and costs nothing but the time of its tasks.

Dask is one way: Spark's ``mapInPandas`` and Ray's ``remote`` take the same functions.
"""

from __future__ import annotations

import os
import pathlib
import signal
import sys
import tempfile
import time

import ironout

SCALE_UT = 0.1
VEHICLES = 4
FLIGHTS = 3
PARTS = 1000


def row(path: str) -> dict:
    """One log as a row of the fleet's table; a log that cannot be read has a row with its error."""
    try:
        diagnosis = ironout.diagnose(path)
    except ironout.IronoutError as error:
        return {"log": path, "verdict": "error", "error": str(error)}
    base = diagnosis.data["base"] or {}
    return {
        "log": path,
        "verdict": diagnosis.verdict,
        "missing": diagnosis.missing,
        "offset_ut": base.get("offset_ut"),
        "rms_ut": base.get("rms_ut"),
    }


def sums(path: str) -> ironout.Moments:
    """The sums of one part."""
    import numpy as np
    import pyarrow.parquet as parquet

    table = parquet.read_table(path)
    time.sleep(0.005)  # as if it were large, so that there is a time to kill a worker in
    return ironout.Moments(np.column_stack([table[name].to_numpy() for name in ("mx_counts", "my_counts", "mz_counts")]))


def merge(parts: list) -> ironout.Moments:
    """The sums of several parts."""
    total = ironout.Moments()
    for part in parts:
        total = total + part
    return total


def make(folder: pathlib.Path) -> tuple[list[str], list[str], ironout.Moments]:
    """Simulated flights, and one long log in parts with the sums of the whole."""
    import numpy as np
    import pyarrow as arrow
    import pyarrow.parquet as parquet

    flights = []
    for vehicle in range(VEHICLES):
        for flight in range(FLIGHTS):
            effects = ["offset:current_a=5"] if vehicle == 1 else []
            log = ironout.simulate(seed=vehicle + 1, recording=flight + 1, seconds=40, effects=effects)
            path = folder / f"v{vehicle}_{flight}.parquet"
            parquet.write_table(arrow.table(log.to_dict()), path)
            flights.append(str(path))
    (folder / "broken.csv").write_text("t_s,mx_ut\n0,1\n")
    flights.append(str(folder / "broken.csv"))
    long = ironout.simulate(seed=9, seconds=600)
    counts = np.round(long.mag / SCALE_UT).astype(np.int16)
    parts = []
    for index, part in enumerate(np.array_split(counts, PARTS)):
        path = folder / f"part{index:03d}.parquet"
        parquet.write_table(arrow.table(dict(zip(("mx_counts", "my_counts", "mz_counts"), part.T))), path)
        parts.append(str(path))
    return flights, parts, ironout.Moments(counts)


def main(folder: pathlib.Path) -> None:
    from distributed import Client, LocalCluster, as_completed

    flights, parts, whole = make(folder)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        table = client.gather(client.map(row, flights))
        assert table == [row(path) for path in flights]
        print(f"{len(table)} logs: {sorted(one['verdict'] for one in table)}; equal to the table of one process")

        futures = client.map(sums, parts)
        done = as_completed(futures)
        next(done)
        victim = next(iter(client.scheduler_info()["workers"].values()))
        pid = client.run(os.getpid)[next(iter(client.scheduler_info()["workers"]))]
        os.kill(pid, signal.SIGKILL)
        print(f"killed worker {victim['id']}")
        # A tree: neighbours first, then what they gave.
        while len(futures) > 1:
            futures = [client.submit(merge, futures[at : at + 8]) for at in range(0, len(futures), 8)]
        merged = futures[0].result()
    scale = (SCALE_UT, SCALE_UT, SCALE_UT)
    assert merged == whole and merged.fit_json(scale) == whole.fit_json(scale)
    print(f"{len(parts)} parts, {merged.count} samples: the calibration of the merged sums equals that of the whole log bit for bit")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main(pathlib.Path(sys.argv[1]))
    else:
        with tempfile.TemporaryDirectory() as temporary:
            main(pathlib.Path(temporary))
