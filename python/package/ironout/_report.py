"""The page about a log."""

from __future__ import annotations

import os
import shutil
import subprocess
from typing import Any

from ._ironout import IronoutError
from ._log import Strings, strings


def report(log: Any, output: Any, *, add: Strings = None, program: Any = None) -> None:
    """Writes the page about a log file: verdict, sphere, plots, and effects as switches.

    The page is made by the program ``ironout`` (on the path, or ``program``), which holds the browser's part.
    """
    found = program or shutil.which("ironout")
    if found is None:
        raise IronoutError(
            "the page is made by the program ironout, which is not on the path. Fix: cargo install --path host-tool --locked "
            "--profile host --features page, or give program="
        )
    command = [os.fspath(found), "report", os.fspath(log), "-o", os.fspath(output)]
    for effect in strings(add):
        command += ["--add", effect]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    # 1: the page is written, and the log supports no calibration.
    if done.returncode not in (0, 1) or not os.path.exists(output):
        raise IronoutError(" ".join((done.stderr or done.stdout).split()).removeprefix("error: "))
