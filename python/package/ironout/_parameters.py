"""Calibrations that an autopilot has in its parameters. The formulas are those of docs/exports.md, read the other way."""

from __future__ import annotations

import json
import os
import re
from typing import Any, Optional

import numpy as np

from . import _ironout
from ._ironout import IronoutError

UT_PER_GAUSS = 100.0
UT_PER_MILLIGAUSS = 0.1


def read(path: Any) -> dict[str, float]:
    """The parameters of a file: lines of QGroundControl (vehicle, component, name, value, type), of Mission Planner (name,value) or of
    MAVProxy (name value)."""
    found: dict[str, float] = {}
    with open(path, encoding="utf-8", errors="replace") as file:
        for line in file:
            cells = re.split(r"[\s,]+", line.split("#")[0].strip())
            if len(cells) >= 4 and cells[0].isdigit() and cells[1].isdigit():
                cells = cells[2:]
            if len(cells) < 2 or not re.fullmatch(r"[A-Z][A-Z0-9_]*", cells[0]):
                continue
            try:
                found[cells[0]] = float(cells[1])
            except ValueError:
                continue
    return found


def px4(path: Any, number: int, field_ut: float, current: Optional[str]) -> str:
    """CAL.json of ``CAL_MAGn_*``."""
    given = read(path)
    name = f"CAL_MAG{number}_"
    offset = _three(path, given, [f"{name}{axis}OFF" for axis in "XYZ"])
    matrix = _symmetric(given, [f"{name}{axis}SCALE" for axis in "XYZ"], [f"{name}{axis}ODIAG" for axis in "XYZ"])
    comp = np.array([given.get(f"{name}{axis}COMP", 0.0) for axis in "XYZ"])
    rotation = int(given.get(f"{name}ROT", -1))
    turn = np.eye(3)
    if rotation > 0:
        rows = _ironout.rotation(rotation)
        if rows is None:
            raise IronoutError(
                f"{os.fspath(path)}: column {name}ROT: {rotation} is not a numbered mounting. Fix: calibrate from a log instead"
            )
        turn = np.array(rows)
    # corrected = turn · matrix · (sensor + power · comp − offset), gauss, with the current in kA.
    coefficients = -comp * UT_PER_GAUSS / 1000
    if comp.any() and int(given.get("CAL_MAG_COMP_TYP", 0)) not in (2, 3):
        raise IronoutError(
            f"{os.fspath(path)}: column CAL_MAG_COMP_TYP: the compensation is not for the current of a battery, and ironout reads no other"
        )
    return _text(turn @ offset * UT_PER_GAUSS, turn @ matrix @ turn.T, turn @ coefficients, field_ut, current, path)


def ardupilot(path: Any, number: int, field_ut: float, current: Optional[str]) -> str:
    """CAL.json of ``COMPASS_*``, in the axes of ArduPilot's logs, which its mounting has turned already."""
    given = read(path)
    n = "" if number == 1 else str(number)
    offset = _three(path, given, [f"COMPASS_OFS{n}_{axis}" for axis in "XYZ"])
    scale = given.get(f"COMPASS_SCALE{n}", 1.0) or 1.0
    matrix = scale * _symmetric(
        given, [f"COMPASS_DIA{n}_{axis}" for axis in "XYZ"], [f"COMPASS_ODI{n}_{axis}" for axis in "XYZ"]
    )
    # field = matrix · (raw + offset) + motor · current, milligauss.
    motor = np.array([given.get(f"COMPASS_MOT{n}_{axis}", 0.0) for axis in "XYZ"])
    if motor.any() and int(given.get("COMPASS_MOTCT", 0)) != 2:
        raise IronoutError(
            f"{os.fspath(path)}: column COMPASS_MOTCT: the compensation is not for the current, and ironout reads no other"
        )
    coefficients = -np.linalg.solve(matrix, motor) * UT_PER_MILLIGAUSS
    return _text(-offset * UT_PER_MILLIGAUSS, matrix, coefficients, field_ut, current, path)


def _three(path: Any, given: dict[str, float], names: list[str]) -> np.ndarray:
    missing = [name for name in names if name not in given]
    if missing:
        raise IronoutError(
            f"{os.fspath(path)}: it does not contain {', '.join(missing)}. Fix: name the magnetometer with number=, and give a file of all parameters"
        )
    return np.array([given[name] for name in names])


def _symmetric(given: dict[str, float], diagonal: list[str], beside: list[str]) -> np.ndarray:
    # Autopilots write 0 for a scale that was never set.
    x, y, z = (given.get(name, 1.0) or 1.0 for name in diagonal)
    xy, xz, yz = (given.get(name, 0.0) for name in beside)
    return np.array([[x, xy, xz], [xy, y, yz], [xz, yz, z]])


def _text(
    offset: np.ndarray, matrix: np.ndarray, coefficients: np.ndarray, field_ut: float, current: Optional[str], path: Any
) -> str:
    effects = []
    if coefficients.any():
        if current is None:
            raise IronoutError(
                f"{os.fspath(path)}: the parameters compensate for a current. Fix: name its column with current=, as in \"current_a\""
            )
        effects.append(
            {
                "id": f"offset:{current}",
                "name": "offset proportional to current",
                "columns": [current],
                "coefficients": coefficients.tolist(),
                "std_errors": [None] * 3,
                "unit": "µT/A",
                "reference": {current: 0.0},
                "parameters": {},
            }
        )
    unknown = ("std_errors", "rms_ut", "holdout_rms_ut", "noise_floor_ut", "residual_floor_ut", "heading_error_deg", "coverage", "gap_deg", "information")
    cal = {
        "version": 1,
        "method": "adjusted",
        "samples_used": 0,
        "samples_set_aside": 0,
        "field_ut": float(field_ut),
        "offset_ut": offset.tolist(),
        "matrix": matrix.tolist(),
        "effects": effects,
        "accepted": True,
        "reasons": [f"note: read from the parameters of {os.fspath(path)}"],
        **{name: None for name in unknown},
    }
    return json.dumps(cal, indent=2, ensure_ascii=False) + "\n"
