"""What a fit and a diagnosis say."""

from __future__ import annotations

import html
import json
from dataclasses import dataclass, field, fields
from typing import Any, Optional

import numpy as np

from . import _plots
from ._calibration import Calibration
from ._ironout import IronoutError
from ._log import Log


def _take(cls: Any, data: dict) -> Any:
    """The dataclass of an object that may have more keys."""
    return cls(**{one.name: data.get(one.name) for one in fields(cls)})


def _frame(rows: list) -> Any:
    import pandas

    return pandas.DataFrame(rows)


@dataclass(frozen=True)
class Effect:
    """An effect in a model."""

    id: str
    name: str
    columns: list
    coefficients: list
    #: Null where the log does not show the coefficient.
    std_errors: list
    unit: str
    reference: dict
    parameters: dict


@dataclass(frozen=True)
class Step:
    """The error with one more effect in the model; the first has offset and matrix only."""

    added: Optional[str]
    rms_ut: float
    holdout_rms_ut: Optional[float]
    dip_rms_deg: Optional[float]


@dataclass(frozen=True)
class Candidate:
    """A candidate and what became of it: ``missing``, ``not-needed``, ``confounded`` or ``untestable``."""

    id: str
    name: str
    status: str
    residual: str
    holdout_rms_ut: Optional[float]
    p_value: Optional[float]
    confounded_with: list
    why: str


class _Plotted:
    """Plots of a log under offset and matrix."""

    log: Log

    def _corrected(self) -> tuple[np.ndarray, np.ndarray]:
        raise NotImplementedError

    def plot_sphere(self, ax: Any = None) -> Any:
        """Corrected vectors on the sphere of the field, coloured by their residual."""
        return _plots.sphere(*self._corrected(), ax=ax)

    def plot_residual(self, column: str = "t_s", ax: Any = None) -> Any:
        """The residual against a column, with its mean and quartiles in bins."""
        return _plots.residual(self.log[column], self._corrected()[1], column, ax=ax)

    def plot_wander(self, ax: Any = None) -> Any:
        """The remaining offset in each of up to 24 blocks of time, with its standard error: does it drift or step?"""
        vectors, residual = self._corrected()
        time = self.log.t if self.log.t is not None else np.arange(len(residual), dtype=float)
        return _plots.wander(time, vectors, residual, "t_s" if self.log.t is not None else "row", ax=ax)


@dataclass(frozen=True)
class Fit(_Plotted):
    """A fit. ``accepted`` says whether its calibration may be used, ``reasons`` why not."""

    method: str
    samples_used: int
    samples_set_aside: int
    field_ut: Optional[float]
    offset_ut: Optional[list]
    matrix: Optional[list]
    effects: list
    std_errors: Optional[dict]
    rms_ut: Optional[float]
    holdout_rms_ut: Optional[float]
    noise_floor_ut: Optional[float]
    residual_floor_ut: Optional[float]
    predicted_error_ut: Optional[float]
    heading_error_deg: Optional[float]
    coverage: Optional[float]
    gap_deg: Optional[float]
    accepted: bool
    reasons: list
    #: The object of the program's ``--json``.
    data: dict = field(repr=False, compare=False)
    #: What the program prints.
    words: str = field(repr=False, compare=False)
    log: Log = field(repr=False, compare=False)
    _cal: Optional[str] = field(repr=False, compare=False)

    @classmethod
    def _of(cls, text: str, cal: Optional[str], words: str, log: Log) -> "Fit":
        data = json.loads(text)
        own = ("data", "words", "log", "_cal", "effects")
        numbers = {name: data.get(name) for name in cls.__dataclass_fields__ if name not in own}
        effects = [_take(Effect, effect) for effect in data["effects"]]
        return cls(**numbers, effects=effects, data=data, words=words, log=log, _cal=cal)

    @property
    def calibration(self) -> Calibration:
        """The calibration of an accepted fit."""
        if self._cal is None:
            raise IronoutError(f"the fit was refused: {'; '.join(self.reasons)}")
        return Calibration(self._cal)

    def to_frame(self) -> Any:
        """Offset and matrix with their standard errors, one row per parameter, as a pandas DataFrame."""
        if self.offset_ut is None or self.matrix is None:
            return _frame([])
        errors = self.std_errors or {}
        offset_std = errors.get("offset_ut", [None] * 3)
        matrix_std = errors.get("matrix", [[None] * 3] * 3)
        rows = [
            {"parameter": f"offset_ut[{i}]", "value": self.offset_ut[i], "std_error": offset_std[i], "unit": "µT"}
            for i in range(3)
        ]
        rows += [
            {"parameter": f"matrix[{i}][{j}]", "value": self.matrix[i][j], "std_error": matrix_std[i][j], "unit": ""}
            for i in range(3)
            for j in range(3)
        ]
        for effect in self.effects:
            for i, (value, error) in enumerate(zip(effect.coefficients, effect.std_errors)):
                rows.append({"parameter": f"{effect.id}[{i}]", "value": value, "std_error": error, "unit": effect.unit})
        return _frame(rows)

    def _corrected(self) -> tuple[np.ndarray, np.ndarray]:
        if self._cal is not None:
            return self.calibration._applied(self.log, {})
        if self.offset_ut is None:
            raise IronoutError(f"there is nothing to plot: {'; '.join(self.reasons)}")
        return _plots.corrected(self.log.mag, self.offset_ut, self.matrix, self.field_ut)

    def plot(self) -> Any:
        """Sphere, magnitude before and after, residual over time."""
        corrected, residual = self._corrected()
        return _plots.fit(self.log, corrected, residual, self.field_ut)

    def __repr__(self) -> str:
        if self.rms_ut is None:
            return f"<ironout.Fit REFUSED: {'; '.join(self.reasons)}>"
        verdict = "ACCEPTED" if self.accepted else "REFUSED"
        return f"<ironout.Fit {verdict}: rms {self.rms_ut:.3f} µT, {self.samples_used} samples>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(self.words)}</pre>"


@dataclass(frozen=True)
class Diagnosis(_Plotted):
    """A diagnosis: ``verdict`` is ``complete``, ``missing``, ``confounded``, ``unexplained`` or ``undetermined``."""

    verdict: str
    reasons: list
    steps: list
    effects: list
    candidates: list
    noise_floor_ut: Optional[float]
    residual_floor_ut: Optional[float]
    predicted_error_ut: Optional[float]
    samples_used: int
    samples_set_aside: int
    data_faults: list
    #: The verdict in one sentence.
    sentence: str
    #: The object of the program's ``--json``.
    data: dict = field(repr=False, compare=False)
    #: What the program prints.
    words: str = field(repr=False, compare=False)
    log: Log = field(repr=False, compare=False)

    @classmethod
    def _of(cls, text: str, sentence: str, words: str, log: Log) -> "Diagnosis":
        data = json.loads(text)
        own = ("data", "words", "log", "sentence", "steps", "effects", "candidates")
        return cls(
            **{name: data.get(name) for name in cls.__dataclass_fields__ if name not in own},
            steps=[_take(Step, step) for step in data["steps"]],
            effects=[_take(Effect, effect) for effect in data["effects"]],
            candidates=[_take(Candidate, candidate) for candidate in data["candidates"]],
            sentence=sentence,
            data=data,
            words=words,
            log=log,
        )

    @property
    def missing(self) -> list[str]:
        """Ids of what was found to be missing."""
        return [candidate.id for candidate in self.candidates if candidate.status == "missing"]

    def to_frame(self) -> Any:
        """The candidates, one row each, as a pandas DataFrame."""
        return _frame(self.data["candidates"])

    def steps_frame(self) -> Any:
        """The error with each effect added, as a pandas DataFrame."""
        return _frame([{one.name: getattr(step, one.name) for one in fields(Step)} for step in self.steps])

    def _corrected(self) -> tuple[np.ndarray, np.ndarray]:
        base = self.data.get("base")
        if base is None:
            raise IronoutError(f"there is no base model to plot: {'; '.join(self.reasons)}")
        return _plots.corrected(self.log.mag, base["offset_ut"], base["matrix"], base["field_ut"])

    def plot(self, ax: Any = None) -> Any:
        """The falling error: rms on the log and on held-out blocks, with each effect added, above the noise floor."""
        return _plots.steps(self.steps, self.residual_floor_ut, ax=ax)

    def __repr__(self) -> str:
        return f"<ironout.Diagnosis {self.sentence}>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(self.words)}</pre>"
