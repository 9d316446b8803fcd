"""Logs: read from a file, from a table in memory, or simulated."""

from __future__ import annotations

import html
import json
import os
import warnings
from typing import Any, Callable, Iterable, Mapping, Optional, Union

import numpy as np

from . import _ironout, _tables

Progress = Callable[[str, float], object]
Strings = Union[str, Iterable[str], None]

PARQUET = (".parquet", ".pq")
FEATHER = (".feather", ".arrow")


class IronoutWarning(UserWarning):
    """What to know about how a log was read or corrected."""


def warn(name: str, notices: Iterable[str]) -> None:
    for notice in notices:
        warnings.warn(f"{name}: {notice}", IronoutWarning, stacklevel=3)


def strings(value: Strings) -> list[str]:
    if value is None:
        return []
    return [value] if isinstance(value, str) else [str(one) for one in value]


def reading(
    name: str,
    *,
    map: Union[Mapping[str, str], Strings] = None,
    rotate: Strings = None,
    ut_per_count: Union[float, Iterable[float], None] = None,
    instance: Optional[int] = None,
    derive: Union[Mapping[str, str], Strings] = None,
    ignore: Strings = None,
    repair: Strings = None,
    date: Optional[str] = None,
) -> str:
    """The options of reading, as the compiled part takes them."""

    def pairs(value: Any) -> list[str]:
        if isinstance(value, Mapping):
            return [f"{key}={one}" for key, one in value.items()]
        return strings(value)

    scale: Optional[str] = None
    if ut_per_count is not None:
        values = [ut_per_count] if isinstance(ut_per_count, (int, float)) else list(ut_per_count)
        scale = ",".join(repr(float(one)) for one in values)
    return json.dumps(
        {
            "name": name,
            "map": pairs(map),
            "rotate": strings(rotate),
            "ut_per_count": scale,
            "instance": instance,
            "derive": pairs(derive),
            "ignore": strings(ignore),
            "repair": strings(repair),
            "date": date,
        }
    )


class Log:
    """A log in columns, in body axes and SI-like units: ``t_s``, ``mx_ut``, ``ax_mps2``, ``gx_radps``, … and any other column."""

    def __init__(self, native: _ironout.Log, truth: Optional[dict] = None) -> None:
        self._native = native
        #: The truth of a simulated log.
        self.truth = truth

    @property
    def name(self) -> str:
        """Name of the file or table."""
        return self._native.name

    @property
    def columns(self) -> list[str]:
        """Names of the columns."""
        return self._native.columns

    @property
    def notices(self) -> list[str]:
        """What to know about how the log was read."""
        return self._native.notices

    @property
    def read_as(self) -> dict:
        """How the log was read: the object ``read_as`` of the program's ``--json``."""
        return json.loads(self._native.read_as())

    @property
    def vehicle(self) -> Optional[str]:
        """Vehicle, if the file names it."""
        return self._native.origin[0]

    @property
    def sensor(self) -> Optional[str]:
        """Magnetometer, if the file names it."""
        return self._native.origin[1]

    @property
    def mag(self) -> np.ndarray:
        """The magnetometer, n × 3, µT."""
        return np.column_stack([self["mx_ut"], self["my_ut"], self["mz_ut"]])

    @property
    def t(self) -> Optional[np.ndarray]:
        """Time, s."""
        return self._native.column("t_s")

    def __getitem__(self, name: str) -> np.ndarray:
        values = self._native.column(name)
        if values is None:
            raise KeyError(f"{name}: the log has {', '.join(self.columns)}")
        return values

    def __contains__(self, name: object) -> bool:
        return name in self.columns

    def __len__(self) -> int:
        return self._native.rows

    def keys(self) -> list[str]:
        return self.columns

    def to_dict(self) -> dict[str, np.ndarray]:
        """The columns as arrays."""
        return {name: self[name] for name in self.columns}

    def to_frame(self) -> Any:
        """The columns as a pandas DataFrame."""
        import pandas

        return pandas.DataFrame(self.to_dict())

    def __repr__(self) -> str:
        return f"<ironout.Log {self.name}: {len(self)} rows, {', '.join(self.columns)}>"

    def _repr_html_(self) -> str:
        words = self._native.read_words() + "".join(f"note: {notice}\n" for notice in self.notices)
        return f"<pre>{html.escape(words)}</pre>"


def read(
    source: Any,
    *,
    field_ut: Optional[float] = None,
    progress: Optional[Progress] = None,
    name: Optional[str] = None,
    **options: Any,
) -> Log:
    """Reads a log: a path of any format that the program reads, a Parquet or Feather file (with pyarrow), a dict of arrays, or a table
    of pandas, polars, pyarrow or xarray.

    Options are those of the command line: ``map``, ``rotate``, ``ut_per_count``, ``instance``, ``derive``, ``ignore``, ``repair``,
    ``date``. ``field_ut`` is the magnitude of a field that is not the Earth's. ``progress(stage, seconds)`` is called while the file
    is read.
    """
    if isinstance(source, Log):
        return source
    if isinstance(source, (str, os.PathLike)):
        path = os.fspath(source)
        if not path.lower().endswith(PARQUET + FEATHER):
            log = Log(_ironout.read(reading(path, **options), field_ut, progress))
            warn(log.name, log.notices)
            return log
        source, name = _arrow(path), name or path
    if not _tables.is_table(source):
        raise TypeError(
            f"{type(source).__name__} is not a log. Fix: give a path, a dict of arrays, or a table with named columns; an n × 3 array "
            "goes to ironout.fit or ironout.diagnose as mag"
        )
    columns, others = _tables.columns(source)
    return from_columns(columns, name or type(source).__name__, field_ut, others, **options)


def from_columns(
    columns: Mapping[str, np.ndarray],
    name: str,
    field_ut: Optional[float],
    others: Iterable[str] = (),
    **options: Any,
) -> Log:
    native = _ironout.from_columns(list(columns), list(columns.values()), reading(name, **options), field_ut)
    log = Log(native)
    warn(log.name, log.notices)
    warn(log.name, [f"column {other} does not contain numbers, so ironout skips it" for other in others])
    return log


def _arrow(path: str) -> Any:
    try:
        if path.lower().endswith(PARQUET):
            import pyarrow.parquet

            return pyarrow.parquet.read_table(path)
        import pyarrow.feather

        return pyarrow.feather.read_table(path)
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(f"{path}: reading it needs pyarrow. Fix: pip install pyarrow") from error


def simulate(
    seed: int = 1,
    seconds: float = 60.0,
    rate_hz: float = 50.0,
    noise_ut: float = 0.25,
    effects: Strings = None,
    recording: int = 1,
    motion: str = "sphere",
    ramp: bool = False,
    without: Strings = None,
) -> Log:
    """A simulated log whose truth is known (``log.truth``): the log that ``ironout simulate`` writes with these options.

    An effect is an id with its strength, as in ``"offset:current_a=5"``: the rms of its disturbance in multiples of the noise.
    """
    native, truth = _ironout.simulate(
        seed, seconds, rate_hz, noise_ut, strings(effects), recording, motion, ramp, strings(without)
    )
    return Log(native, json.loads(truth))
