"""Where the files are that tests read."""

import os
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SAMPLE = ROOT / "data" / "flight.tlog"
EXAMPLES = ROOT / "examples"
ARDUCOPTER = ROOT / "tests" / "data" / "arducopter"
"""How a real ArduCopter 4.6 flew six missions."""
DATAFLASH = ROOT / "tests" / "data" / "dataflash"
"""One flight of a real ArduCopter 4.6, logged on board and over the link at once, packed."""
OTHER_LOGS = Path(os.environ.get("FLIGHT_REPLAY_LOGS", os.devnull))
"""A folder of logs that are not the project's to give away; without it their tests are skipped."""


def other_log(name: str) -> Path:
    """One of the other logs, or the test that asks for it is skipped."""
    path = OTHER_LOGS / name
    if not path.is_file():
        pytest.skip("FLIGHT_REPLAY_LOGS names no folder with this log")
    return path
