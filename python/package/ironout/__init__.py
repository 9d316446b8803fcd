"""Magnetometer calibration and the search for the missing effect.

>>> import ironout
>>> log = ironout.simulate(seed=1, seconds=60)
>>> fit = ironout.fit(log)
>>> fit.accepted
True
"""

from ._calibration import Calibration, Check, check
from ._ironout import IronoutError, Moments, __version__
from ._log import IronoutWarning, Log, read, simulate
from ._report import report
from ._results import Candidate, Diagnosis, Effect, Fit, Step
from ._run import diagnose, fit
from ._sums import moments

__all__ = [
    "Calibration",
    "Candidate",
    "Check",
    "Diagnosis",
    "Effect",
    "Fit",
    "IronoutError",
    "IronoutWarning",
    "Log",
    "Moments",
    "Step",
    "__version__",
    "check",
    "diagnose",
    "fit",
    "moments",
    "read",
    "report",
    "simulate",
]
