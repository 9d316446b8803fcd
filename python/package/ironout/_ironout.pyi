"""The compiled part. Results are the JSON texts of the program's ``--json``."""

from typing import Callable, Optional, Sequence, Tuple

import numpy as np
import numpy.typing as npt

__version__: str

Progress = Callable[[str, float], object]

class IronoutError(Exception):
    """Bad input, or a request that cannot be met. ``str()`` names the place and the remedy."""

    file: Optional[str]
    line: Optional[int]
    column: Optional[str]
    message: str
    exit_status: int

class Log:
    name: str
    rows: int
    notices: list[str]
    origin: Tuple[Optional[str], Optional[str], Optional[str]]
    columns: list[str]
    def read_as(self) -> str: ...
    def read_words(self) -> str: ...
    def column(self, name: str) -> Optional[npt.NDArray[np.float64]]: ...
    def __len__(self) -> int: ...

class Moments:
    """Exact integer sums of 16-bit samples. Sums of parts merge exactly, in any order."""

    count: int
    def __init__(self, counts: Optional[npt.NDArray[np.int16]] = None) -> None: ...
    def sums(self) -> list[str]: ...
    @staticmethod
    def from_sums(sums: Sequence[str]) -> "Moments": ...
    def __add__(self, other: "Moments") -> "Moments": ...
    def fit_json(
        self,
        ut_per_count: Tuple[float, float, float],
        field_ut: Optional[float] = None,
        method: str = "adjusted",
    ) -> str: ...

def read(asked: str, field_ut: Optional[float] = None, progress: Optional[Progress] = None) -> Log: ...
def from_columns(
    names: Sequence[str],
    values: Sequence[npt.NDArray[np.float64]],
    asked: str,
    field_ut: Optional[float] = None,
) -> Log: ...
def simulate(
    seed: int,
    seconds: float,
    rate: float,
    noise: float,
    effect: Sequence[str],
    recording: int,
    motion: str,
    ramp: bool,
    without: Sequence[str],
) -> Tuple[Log, str]: ...
def fit(log: Log, asked: str, progress: Optional[Progress] = None) -> Tuple[str, Optional[str], str]: ...
def diagnose(log: Log, asked: str, progress: Optional[Progress] = None) -> Tuple[str, str, str]: ...
def rotation(number: int) -> Optional[list[list[float]]]: ...
def parse(cal: str, name: str) -> str: ...
def apply(
    cal: str, name: str, log: Log
) -> Tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], list[str]]: ...
def check(cal: str, name: str, log: Log, declination: Optional[float] = None) -> str: ...
def check_file(cal: str, name: str, asked: str, declination: Optional[float] = None) -> str: ...
def export(
    cal: str,
    name: str,
    form: str,
    log: Optional[Log] = None,
    number: Optional[int] = None,
    device_id: Optional[int] = None,
    euler: bool = False,
    ut_per_count: Optional[str] = None,
) -> str: ...
