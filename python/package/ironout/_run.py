"""``fit`` and ``diagnose``."""

from __future__ import annotations

import contextlib
import json
import os
import tempfile
from typing import Any, Iterator, Optional, Union

import numpy as np

from . import _ironout, _tables
from ._calibration import Calibration
from ._log import Log, Progress, Strings, from_columns, read, strings
from ._results import Diagnosis, Fit

READING = ("map", "rotate", "ut_per_count", "instance", "derive", "ignore", "repair", "date", "name")
AXES = {
    "mag": ("mx_ut", "my_ut", "mz_ut"),
    "accel": ("ax_mps2", "ay_mps2", "az_mps2"),
    "gyro": ("gx_radps", "gy_radps", "gz_radps"),
}


def fit(
    mag: Any,
    t: Any = None,
    accel: Any = None,
    gyro: Any = None,
    *,
    field_ut: Optional[float] = None,
    at: Optional[str] = None,
    method: str = "adjusted",
    add: Strings = None,
    force_effect: bool = False,
    prior: Any = None,
    free: Optional[str] = None,
    attitudes: Union[str, float, None] = None,
    progress: Optional[Progress] = None,
    **columns: Any,
) -> Fit:
    """Calibrates: offset and matrix, their standard errors, a verdict. A refused fit is a result with ``accepted == False``.

    ``mag`` is a log (or what :func:`read` takes), or an n × 3 array in µT; then ``t`` (s), ``accel`` (m/s²), ``gyro`` (rad/s) and any
    further columns by name are arrays of as many rows. ``add`` names effects for the model, ``prior`` is an earlier calibration;
    ``free="offset"`` takes only its matrix as known. ``attitudes`` is what ``--for`` is on the command line: ``"all"``, ``"level"``, ``"boat"`` or degrees of
    tilt. An attitude worked out by an autopilot goes into the columns ``q_w``, ``q_x``, ``q_y``, ``q_z``.
    """
    log = _log(mag, t, accel, gyro, field_ut, progress, columns)
    with _prior(prior) as path:
        asked = _asked(field_ut, at, method, add, force_effect, path, free, attitudes)
        text, cal, words = _ironout.fit(log._native, asked, progress)
    return Fit._of(text, cal, words, log)


def diagnose(
    mag: Any,
    t: Any = None,
    accel: Any = None,
    gyro: Any = None,
    *,
    field_ut: Optional[float] = None,
    at: Optional[str] = None,
    method: str = "adjusted",
    add: Strings = None,
    prior: Any = None,
    progress: Optional[Progress] = None,
    **columns: Any,
) -> Diagnosis:
    """Finds the missing effect: what offset and matrix do not explain, and which column or motion explains it.

    Arguments are those of :func:`fit`.
    """
    log = _log(mag, t, accel, gyro, field_ut, progress, columns)
    with _prior(prior) as path:
        asked = _asked(field_ut, at, method, add, True, path)
        text, sentence, words = _ironout.diagnose(log._native, asked, progress)
    return Diagnosis._of(text, sentence, words, log)


def _log(
    mag: Any,
    t: Any,
    accel: Any,
    gyro: Any,
    field_ut: Optional[float],
    progress: Optional[Progress],
    columns: dict[str, Any],
) -> Log:
    options = {name: columns.pop(name) for name in READING if name in columns}
    if isinstance(mag, (Log, str, os.PathLike)) or _tables.is_table(mag):
        given = [name for name, value in (("t", t), ("accel", accel), ("gyro", gyro)) if value is not None]
        if given or columns:
            raise TypeError(
                f"{', '.join(given + list(columns))}: a log has its own columns. Fix: put them into the table, or give mag as an "
                "n × 3 array"
            )
        return read(mag, field_ut=field_ut, progress=progress, **options)
    table: dict[str, np.ndarray] = {}
    if t is not None:
        table["t_s"] = _column("t", t)
    for name, value in (("mag", mag), ("accel", accel), ("gyro", gyro)):
        if value is not None:
            array = np.asarray(value, dtype=np.float64)
            if array.ndim != 2 or array.shape[1] != 3:
                raise ValueError(f"{name} has the shape {array.shape}. Fix: give an array of n rows with x, y and z")
            table.update(zip(AXES[name], np.ascontiguousarray(array.T)))
    for name, value in columns.items():
        table[name] = _column(name, value)
    return from_columns(table, options.pop("name", "mag"), field_ut, **options)


def _column(name: str, value: Any) -> np.ndarray:
    numbers, _ = _tables.columns({name: value})
    if name not in numbers:
        raise TypeError(f"{name} is no option and no column of numbers. Fix: give an array with one number per row")
    return numbers[name]


def _asked(
    field_ut: Optional[float],
    at: Optional[str],
    method: str,
    add: Strings,
    force_effect: bool,
    prior: Optional[str],
    free: Optional[str] = None,
    attitudes: Union[str, float, None] = None,
) -> str:
    return json.dumps(
        {
            "field_ut": field_ut,
            "at": at,
            "method": method,
            "add": strings(add),
            "force_effect": force_effect,
            "prior": prior,
            "free": free,
            "for": None if attitudes is None else str(attitudes),
        }
    )


@contextlib.contextmanager
def _prior(prior: Any) -> Iterator[Optional[str]]:
    """The file of an earlier calibration."""
    if not isinstance(prior, Calibration):
        yield None if prior is None else os.fspath(prior)
        return
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "cal.json")
        prior.save(path)
        yield path
