"""Arms the built-in copter, whose checks take some seconds of its time."""

from __future__ import annotations

import pytest

from flight_replay.supervisor.vehicle_interface import Heartbeat
from flight_replay.vehicle import ConnectedVehicle

_TRIES = 120
"""Reports are waited for a second at most."""


def wait_armed(vehicle: ConnectedVehicle) -> None:
    """Ask for GUIDED and to arm until a heartbeat shows both."""
    for _ in range(_TRIES):
        vehicle.request_mode("GUIDED")
        vehicle.request_arm()
        if Heartbeat("GUIDED", True) in vehicle.reports(1.0):
            return
    pytest.fail("the copter does not arm")
