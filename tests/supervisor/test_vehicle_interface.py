"""The clock of a real flight."""

from __future__ import annotations

import time

from flight_replay.supervisor.vehicle_interface import WallClock


def test_the_wall_clock_never_runs_backwards() -> None:
    """It is the computer's monotonic clock."""
    before_s = time.monotonic()
    now_s = WallClock().monotonic_s()
    assert before_s <= now_s <= time.monotonic()
