"""Which log to read when none is named."""

from __future__ import annotations

import os
from pathlib import Path

DEFAULT_NAME = "flight.tlog"


def default_log() -> Path:
    """``flight.tlog`` in the current folder, else the sample flight that comes with the package.

    What has that name but is no log, such as a link that leads nowhere, is for the reader to refuse.
    """
    here = Path(DEFAULT_NAME)
    return here if os.path.lexists(here) else sample_log()


def sample_log() -> Path:
    """The sample flight: in the wheel in the package, in a source tree in ``data/``."""
    package = Path(__file__).resolve().parents[1]
    packaged = package / "data" / DEFAULT_NAME
    return packaged if packaged.is_file() else package.parents[1] / "data" / DEFAULT_NAME
