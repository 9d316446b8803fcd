"""Calibrations: saved, applied, checked, exported."""

from __future__ import annotations

import html
import json
import os
from dataclasses import dataclass, field
from typing import Any, Optional

import numpy as np

from . import _ironout, _parameters
from ._log import Log, read, reading, warn


class Calibration:
    """``corrected = matrix · (measured − offset)``, with the effects that were fitted: the content of CAL.json."""

    def __init__(self, text: str, name: str = "calibration") -> None:
        # Checked number by number, as the program does before it uses a file.
        self._text = text
        self._name = name
        self._data = json.loads(_ironout.parse(text, name))

    @classmethod
    def load(cls, path: Any) -> "Calibration":
        """Reads CAL.json."""
        with open(path, encoding="utf-8") as file:
            return cls(file.read(), os.fspath(path))

    @classmethod
    def from_px4(cls, path: Any, number: int = 0, *, field_ut: float, current: Optional[str] = None) -> "Calibration":
        """The calibration in PX4's parameters (a file of QGroundControl), for magnetometer ``number`` (0 to 3), in body axes.

        Parameters do not contain the magnitude of the field, so ``field_ut`` gives it. ``current`` is the column of the current that
        the autopilot compensates for. Thermal compensation is not read.
        """
        return cls(_parameters.px4(path, number, field_ut, current), os.fspath(path))

    @classmethod
    def from_ardupilot(cls, path: Any, number: int = 1, *, field_ut: float, current: Optional[str] = None) -> "Calibration":
        """The calibration in ArduPilot's parameters, for compass ``number`` (1 to 3), in the axes of its logs.

        Arguments are those of :meth:`from_px4`.
        """
        return cls(_parameters.ardupilot(path, number, field_ut, current), os.fspath(path))

    def save(self, path: Any) -> None:
        """Writes CAL.json. A file that exists is replaced only when the new one is whole."""
        part = f"{os.fspath(path)}.part"
        with open(part, "w", encoding="utf-8") as file:
            file.write(self._text)
        os.replace(part, path)

    @property
    def data(self) -> dict:
        """All of CAL.json."""
        return self._data

    @property
    def offset_ut(self) -> np.ndarray:
        """Offset (hard iron), µT."""
        return np.array(self._data["offset_ut"])

    @property
    def matrix(self) -> np.ndarray:
        """Matrix (soft iron, gains, alignment)."""
        return np.array(self._data["matrix"])

    @property
    def field_ut(self) -> float:
        """Magnitude of corrected vectors, µT."""
        return self._data["field_ut"]

    @property
    def effects(self) -> list[str]:
        """Ids of the effects in the model."""
        return [effect["id"] for effect in self._data["effects"]]

    def apply(self, log: Any, **columns: Any) -> np.ndarray:
        """Corrected vectors, n × 3, µT, of a log or of an n × 3 array (with the columns that the effects need, by name)."""
        return self._applied(log, columns)[0]

    def residual(self, log: Any, **columns: Any) -> np.ndarray:
        """Magnitude of the corrected vectors minus the field, µT."""
        return self._applied(log, columns)[1]

    def _applied(self, log: Any, columns: dict) -> tuple[np.ndarray, np.ndarray]:
        from ._run import _log

        held = _log(log, columns.pop("t", None), columns.pop("accel", None), columns.pop("gyro", None), None, None, columns)
        corrected, residual, notes = _ironout.apply(self._text, self._name, held._native)
        warn(held.name, notes)
        return corrected, residual

    def check(self, log: Any, declination: Optional[float] = None, **options: Any) -> "Check":
        """Whether the calibration is still good for a log."""
        return check(log, self, declination, **options)

    def export(
        self,
        form: str,
        path: Any = None,
        *,
        log: Any = None,
        number: Optional[int] = None,
        device_id: Optional[int] = None,
        euler: bool = False,
        ut_per_count: Optional[float] = None,
    ) -> str:
        """The calibration as ``rust``, ``c``, ``json``, ``px4``, ``ardupilot``, ``betaflight``, ``ros`` or ``iio``; written to ``path`` if
        one is given."""
        held = None if log is None else read(log)._native
        scale = None if ut_per_count is None else repr(float(ut_per_count))
        text = _ironout.export(self._text, self._name, form, held, number, device_id, euler, scale)
        if path is not None:
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
        return text

    def __repr__(self) -> str:
        offset = ", ".join(f"{value:.2f}" for value in self.offset_ut)
        effects = f", effects {', '.join(self.effects)}" if self.effects else ""
        return f"<ironout.Calibration offset [{offset}] µT, field {self.field_ut:.2f} µT{effects}>"

    def _repr_html_(self) -> str:
        rows = "".join(
            "<tr><th>{}</th>{}<td>{:.3f}</td></tr>".format(
                axis, "".join(f"<td>{cell:.5f}</td>" for cell in self.matrix[index]), self.offset_ut[index]
            )
            for index, axis in enumerate("xyz")
        )
        effects = html.escape(", ".join(self.effects) or "none")
        return (
            f"<table><tr><th></th><th colspan=3>matrix</th><th>offset, µT</th></tr>{rows}</table>"
            f"<p>field {self.field_ut:.3f} µT; effects: {effects}</p>"
        )


@dataclass(frozen=True)
class Check:
    """Result of checking a calibration against a log."""

    #: ``good``, ``field``, ``moved``, ``other``, ``worse``, ``heading`` or ``unknown``.
    verdict: str
    #: Whether the calibration can be kept.
    good: bool
    samples: int
    rms_ut: Optional[float]
    limit_ut: float
    calibration_rms_ut: Optional[float]
    coverage: float
    offset_shift_ut: Optional[list]
    reasons: list
    #: The object of the program's ``--json``.
    data: dict = field(repr=False, compare=False)

    @classmethod
    def _of(cls, text: str) -> "Check":
        data = json.loads(text)
        names = [name for name in cls.__dataclass_fields__ if name != "data"]
        return cls(**{name: data[name] for name in names}, data=data)

    def to_frame(self) -> Any:
        """One row, as a pandas DataFrame."""
        import pandas

        return pandas.DataFrame([{key: value for key, value in self.data.items() if key != "read_as"}])

    def _repr_html_(self) -> str:
        reasons = "".join(f"<li>{html.escape(reason)}</li>" for reason in self.reasons)
        return f"<p><b>{self.verdict.upper()}</b>: rms {self.rms_ut:.3f} µT, limit {self.limit_ut:.3f} µT</p><ul>{reasons}</ul>"


def check(log: Any, calibration: Any, declination: Optional[float] = None, **options: Any) -> Check:
    """Whether a calibration is still good for a log. A path is read as the log of the calibration was."""
    cal = calibration if isinstance(calibration, Calibration) else Calibration.load(calibration)
    if isinstance(log, (str, os.PathLike)) and not os.fspath(log).lower().endswith((".parquet", ".pq", ".feather", ".arrow")):
        text = _ironout.check_file(cal._text, cal._name, reading(os.fspath(log), **options), declination)
    else:
        held: Log = read(log, **options)
        text = _ironout.check(cal._text, cal._name, held._native, declination)
    return Check._of(text)
