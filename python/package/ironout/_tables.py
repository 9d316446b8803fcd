"""Tables of any library as named columns of numbers."""

from __future__ import annotations

from typing import Any, Mapping

import numpy as np


def is_table(value: Any) -> bool:
    """Whether a value has named columns: a mapping, or a table of pandas, polars, pyarrow or xarray."""
    if isinstance(value, Mapping):
        return True
    return any(hasattr(value, name) for name in ("column_names", "data_vars", "columns"))


def columns(table: Any) -> tuple[dict[str, np.ndarray], list[str]]:
    """The numeric columns of a table, and the names of those that hold no numbers."""
    numbers: dict[str, np.ndarray] = {}
    others: list[str] = []
    for name in _names(table):
        values = _number(table[name])
        if values is None:
            others.append(str(name))
        else:
            numbers[str(name)] = values
    index = getattr(table, "index", None)
    if "t_s" not in numbers and getattr(getattr(index, "dtype", None), "kind", None) == "M":
        numbers["t_s"] = _seconds(np.asarray(index))
    return numbers, others


def _names(table: Any) -> list[Any]:
    if isinstance(table, Mapping):
        # An xarray.Dataset is a mapping of its variables; its coordinates count too.
        return list(table.keys()) + [name for name in getattr(table, "coords", ()) if name not in table.keys()]
    if hasattr(table, "column_names"):
        return list(table.column_names)
    return list(table.columns)


def _number(values: Any) -> np.ndarray | None:
    """One column as double precision; None if it does not contain numbers. Missing cells are NaN."""
    if hasattr(values, "to_numpy"):
        array = values.to_numpy()
    else:
        array = np.asarray(values)
    array = np.asarray(array)
    if array.dtype.kind == "M":
        return _seconds(array)
    if array.dtype.kind == "O":
        try:
            array = np.array([np.nan if value is None else value for value in array], dtype=float)
        except (TypeError, ValueError):
            return None
    if array.dtype.kind not in "fiub" or array.ndim != 1:
        return None
    return np.ascontiguousarray(array, dtype=np.float64)


def _seconds(times: np.ndarray) -> np.ndarray:
    """Dates as seconds since 1970."""
    seconds = times.astype("datetime64[ns]").astype(np.int64) / 1e9
    return np.where(np.isnat(times), np.nan, seconds)
