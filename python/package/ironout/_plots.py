"""Plots with matplotlib for publications: labelled axes with units, colours that differ in a grey print."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np

BEFORE, AFTER, FLOOR = "#b04a2f", "#1f5a92", "#555555"
BINS = 30
MIN_IN_BIN = 5
MAX_POINTS = 4000
BLOCKS = 24
MIN_IN_BLOCK = 50
#: Room for the legend under the title.
LEGEND_HEIGHT_PT = 20
UNITS = {
    "s": "s", "ut": "µT", "nt": "nT", "mps2": "m/s²", "mps": "m/s", "radps": "rad/s", "deg": "°", "rad": "rad",
    "c": "°C", "a": "A", "v": "V", "w": "W", "m": "m", "hz": "Hz", "pa": "Pa", "pct": "%",
}
#: Beyond this number of characters, labels side by side would overlap.
MAX_LABEL_CHARS = 48
#: Of the normal matrix: beyond it a block has too few directions for an offset.
MAX_CONDITION = 300.0


def corrected(mag: np.ndarray, offset_ut: Any, matrix: Any, field_ut: Any) -> tuple[np.ndarray, np.ndarray]:
    """Vectors under offset and matrix, and their residuals."""
    vectors = (mag - np.array(offset_ut)) @ np.array(matrix).T
    return vectors, np.linalg.norm(vectors, axis=1) - field_ut


def _axes(ax: Any, **figure: Any) -> Any:
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    return plt.subplots(layout="constrained", **figure)[1]


def _legend(ax: Any, columns: int) -> None:
    # Between the title and the axes: it must not lie on samples.
    ax.legend(
        loc="lower center", bbox_to_anchor=(0.5, 1.0), borderaxespad=0, ncols=columns, frameon=False, fontsize="small",
        markerscale=2, columnspacing=1.2,
    )
    ax.set_title(ax.get_title(), pad=LEGEND_HEIGHT_PT)


def _label(name: str) -> str:
    """Name of a column with its unit: the end of the name."""
    stem, _, unit = name.rpartition("_")
    return "time, s" if name == "t_s" else f"{name}, {UNITS[unit]}" if stem and unit in UNITS else name


def _thin(count: int) -> slice:
    return slice(None, None, max(1, -(-count // MAX_POINTS)))


def sphere(vectors: np.ndarray, residual: np.ndarray, ax: Any = None) -> Any:
    import matplotlib.ticker

    if ax is None:
        ax = _axes(None, figsize=(5.2, 4.4), subplot_kw={"projection": "3d"})
    field_ut = float(np.median(np.linalg.norm(vectors, axis=1)))
    turn, tilt = np.meshgrid(np.linspace(0, 2 * np.pi, 37), np.linspace(0, np.pi, 19))
    x, y, z = np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)
    ax.plot_wireframe(field_ut * x, field_ut * y, field_ut * z, color="0.85", linewidth=0.4)
    few = _thin(len(vectors))
    most = max(float(np.quantile(np.abs(residual), 0.98)), 1e-9)
    points = ax.scatter(*vectors[few].T, c=residual[few], s=4, cmap="RdBu_r", vmin=-most, vmax=most, depthshade=False)
    ax.set_xlabel("x, µT")
    ax.set_ylabel("y, µT")
    ax.set_zlabel("z, µT")
    for name in "xyz":
        getattr(ax, f"set_{name}lim")(-1.1 * field_ut, 1.1 * field_ut)
        getattr(ax, f"{name}axis").set_major_locator(matplotlib.ticker.MaxNLocator(4))
    ax.set_box_aspect((1, 1, 1))
    ax.set_title("Corrected vectors")
    ax.figure.colorbar(points, ax=ax, label="residual, µT", shrink=0.7, pad=0.14)
    return ax


def residual(column: np.ndarray, values: np.ndarray, name: str, ax: Any = None) -> Any:
    ax = _axes(ax, figsize=(5.2, 3.4))
    good = np.isfinite(column) & np.isfinite(values)
    x, y = column[good], values[good]
    few = _thin(len(x))
    ax.plot(x[few], y[few], ".", color="0.7", markersize=2, label="samples", zorder=1)
    edges = np.unique(np.quantile(x, np.linspace(0, 1, BINS + 1))) if len(x) else np.array([])
    centres, means, quartiles = [], [], []
    for low, high in zip(edges[:-1], edges[1:]):
        inside = (x >= low) & (x <= high)
        if inside.sum() >= MIN_IN_BIN:
            # Not the middle of the bin: a bin may span a gap without samples.
            centres.append(x[inside].mean())
            means.append(y[inside].mean())
            quartiles.append(np.quantile(y[inside], [0.25, 0.75]))
    if centres:
        # No standard errors: neighbouring samples are not independent.
        ax.fill_between(centres, *np.transpose(quartiles), color=AFTER, alpha=0.25, linewidth=0, label="half of the samples")
        ax.plot(centres, means, "o-", color=AFTER, markersize=3, linewidth=1, label="mean")
    ax.axhline(0, color=FLOOR, linewidth=0.8)
    ax.set_xlabel(_label(name))
    ax.set_ylabel("residual, µT")
    ax.set_title(f"Residual by {'time' if name == 't_s' else name}")
    _legend(ax, 3)
    return ax


def steps(rows: list, floor_ut: Optional[float], ax: Any = None) -> Any:
    ax = _axes(ax, figsize=(5.2, 3.4))
    names = ["offset, matrix"] + [f"+ {row.added}" for row in rows[1:]]
    places = np.arange(len(rows))
    held_out = [np.nan if row.holdout_rms_ut is None else row.holdout_rms_ut for row in rows]
    ax.bar(places - 0.2, [row.rms_ut for row in rows], 0.4, color=AFTER, label="on the log")
    ax.bar(places + 0.2, held_out, 0.4, color=BEFORE, label="held out (10-fold)")
    if floor_ut is not None:
        ax.axhline(floor_ut, color=FLOOR, linestyle="--", linewidth=1, label="noise floor")
    crowded = sum(map(len, names)) > MAX_LABEL_CHARS
    ax.set_xticks(places, names, **({"rotation": 20, "ha": "right"} if crowded else {}))
    ax.set_ylabel("rms residual, µT")
    ax.set_title("Error with each effect added")
    _legend(ax, 3)
    return ax


def wander(time: np.ndarray, vectors: np.ndarray, residual: np.ndarray, name: str, ax: Any = None) -> Any:
    """The remaining offset in blocks of time: least squares of the residual on the direction of the field."""
    ax = _axes(ax, figsize=(5.2, 3.4))
    good = np.isfinite(residual) & np.isfinite(time) & (np.linalg.norm(vectors, axis=1) > 0)
    time, vectors, residual = time[good], vectors[good], residual[good]
    blocks = np.array_split(np.arange(len(time)), max(1, min(BLOCKS, len(time) // MIN_IN_BLOCK)))
    centres, offsets, errors = [], [], []
    for block in blocks:
        if len(block) < MIN_IN_BLOCK:
            continue
        directions = vectors[block] / np.linalg.norm(vectors[block], axis=1)[:, None]
        normal = directions.T @ directions
        if np.linalg.cond(normal) > MAX_CONDITION:
            continue
        offset = np.linalg.solve(normal, directions.T @ residual[block])
        variance = np.sum((residual[block] - directions @ offset) ** 2) / (len(block) - 3)
        centres.append(time[block].mean())
        offsets.append(offset)
        errors.append(np.sqrt(variance * np.diag(np.linalg.inv(normal))))
    for axis, (colour, marker) in enumerate(zip((BEFORE, AFTER, FLOOR), "os^")):
        if centres:
            values, error = np.array(offsets)[:, axis], np.array(errors)[:, axis]
            ax.errorbar(np.array(centres), values, error, color=colour, marker=marker, markersize=3, linewidth=1, label="xyz"[axis])
    ax.axhline(0, color="0.85", linewidth=0.8, zorder=0)
    ax.set_xlabel(_label(name))
    ax.set_ylabel("remaining offset, µT")
    ax.set_title("Offset over time")
    if centres:
        _legend(ax, 3)
    else:
        ax.text(0.5, 0.5, "too few directions in each block of time", transform=ax.transAxes, ha="center", va="center")
    return ax


def fit(log: Any, vectors: np.ndarray, values: np.ndarray, field_ut: Optional[float]) -> Any:
    import matplotlib.pyplot as plt

    figure = plt.figure(figsize=(10, 4.6), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=[1, 1.15])
    sphere(vectors, values, ax=figure.add_subplot(grid[:, 0], projection="3d"))
    time = log.t if log.t is not None else np.arange(len(vectors), dtype=float)
    magnitudes = figure.add_subplot(grid[0, 1])
    few = _thin(len(vectors))
    magnitudes.plot(time[few], np.linalg.norm(log.mag, axis=1)[few], ".", markersize=2, color=BEFORE, label="measured")
    magnitudes.plot(time[few], np.linalg.norm(vectors, axis=1)[few], ".", markersize=2, color=AFTER, label="corrected")
    if field_ut is not None:
        magnitudes.axhline(field_ut, color=FLOOR, linewidth=0.8)
    magnitudes.set_ylabel("magnitude, µT")
    magnitudes.set_title("Magnitude")
    _legend(magnitudes, 2)
    residual(time, values, "t_s" if log.t is not None else "row", ax=figure.add_subplot(grid[1, 1], sharex=magnitudes))
    return figure
