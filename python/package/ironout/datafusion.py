"""``mag_fit(x, y, z)``: a calibration as an aggregate of SQL, with DataFusion (``pip install datafusion``).

    import datafusion, ironout.datafusion

    context = datafusion.SessionContext()
    context.register_parquet("log", "flights.parquet")
    context.register_udaf(ironout.datafusion.mag_fit(ut_per_count=0.1))
    context.sql("SELECT vehicle, mag_fit(mx, my, mz) AS fit FROM log GROUP BY vehicle")

The state of the aggregate is the exact sums of 35 integers: partitions merge in any order to the same bits. DataFusion's own scan of
the file takes more memory the longer the file is; ``ironout.moments`` takes that of one batch.
"""

from __future__ import annotations

import json
from typing import Any, List, Optional, Sequence, Union

import pyarrow as arrow
from datafusion import Accumulator, AggregateUDF, udaf

from ._ironout import IronoutError, Moments
from ._sums import COUNTS, _triples

RESULT = arrow.struct(
    [
        ("offset_ut", arrow.list_(arrow.float64())),
        ("matrix", arrow.list_(arrow.list_(arrow.float64()))),
        ("field_ut", arrow.float64()),
        ("rms_ut", arrow.float64()),
        ("samples", arrow.uint64()),
        ("refused", arrow.string()),
    ]
)


def mag_fit(
    ut_per_count: Union[float, Sequence[float]],
    field_ut: Optional[float] = None,
    method: str = "adjusted",
    name: str = "mag_fit",
    counts: Optional[arrow.DataType] = None,
) -> AggregateUDF:
    """The aggregate for counts of this scale. Its result is a struct; ``refused`` says why there is no calibration.

    ``counts`` is the type of the three columns, ``int16`` unless given.
    """
    scale = (float(ut_per_count),) * 3 if isinstance(ut_per_count, (int, float)) else tuple(ut_per_count)
    if len(scale) != 3:
        raise IronoutError(f"ut_per_count has {len(scale)} numbers: expected one, or one for each axis")

    class MagFit(Accumulator):
        def __init__(self) -> None:
            self.sums = Moments()

        def update(self, *columns: Any) -> None:
            self.sums = self.sums + Moments(_triples(columns, COUNTS))

        def merge(self, states: List[Any]) -> None:
            for sums in states[0].to_pylist() if isinstance(states, list) else states.to_pylist():
                self.sums = self.sums + Moments.from_sums(sums)

        def state(self) -> List[Any]:
            return [arrow.scalar(self.sums.sums(), type=arrow.list_(arrow.string()))]

        def evaluate(self) -> Any:
            row = {"samples": self.sums.count}
            try:
                fit = json.loads(self.sums.fit_json(scale, field_ut, method))
                row.update((key, fit[key]) for key in ("offset_ut", "matrix", "field_ut", "rms_ut"))
            except IronoutError as error:
                row["refused"] = str(error)
            return arrow.scalar(row, type=RESULT)

    return udaf(MagFit, [counts or arrow.int16()] * 3, RESULT, [arrow.list_(arrow.string())], "immutable", name=name)
