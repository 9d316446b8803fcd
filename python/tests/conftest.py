"""What the tests share: a log with a hidden effect, and the program to compare with."""

import json
import os
import pathlib
import subprocess

import pytest

import ironout

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("IRONOUT_PROGRAM")


@pytest.fixture(scope="session")
def program():
    """Runs the program and gives the object of --json. Without it the comparison cannot be made, which is a failure in CI."""
    if PROGRAM is None:
        pytest.skip("IRONOUT_PROGRAM names no program to compare with")

    def run(*arguments, status=0):
        command = [PROGRAM, *map(str, arguments), "--json"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == status, done.stdout + done.stderr
        return json.loads(done.stdout)

    return run


def of_the_log(data):
    """The answer without what the program says of its file and of itself."""
    program = ("report", "input", "notes", "version", "reason_codes")
    return {key: value for key, value in data.items() if key not in program}


def without_names(data):
    """The same without how a log was read, which names a format: it differs for a table in memory."""
    return {key: value for key, value in of_the_log(data).items() if key != "read_as"}


def write(log, path):
    """A log as CSV whose numbers come back to the last bit."""
    columns = log.to_dict()
    with open(path, "w", encoding="utf-8") as file:
        file.write(",".join(columns) + "\n")
        for row in zip(*columns.values()):
            file.write(",".join("" if value != value else repr(float(value)) for value in row) + "\n")
    return path


@pytest.fixture(scope="session")
def clean():
    return ironout.simulate(seed=7, seconds=40)


@pytest.fixture(scope="session")
def hidden():
    """A log in which the offset follows the current."""
    return ironout.simulate(seed=1, seconds=60, effects="offset:current_a=5")


@pytest.fixture(scope="session")
def clean_file(clean, tmp_path_factory):
    return write(clean, tmp_path_factory.mktemp("logs") / "clean.csv")


@pytest.fixture(scope="session")
def hidden_file(hidden, tmp_path_factory):
    return write(hidden, tmp_path_factory.mktemp("logs") / "hidden.csv")
