"""Arms the built-in copter, whose checks take some seconds of its time."""

from __future__ import annotations

import time

import pytest

from flight_replay.supervisor.vehicle_interface import Heartbeat
from flight_replay.vehicle import ConnectedVehicle

_LONGEST_S = 120.0


def wait_armed(vehicle: ConnectedVehicle) -> None:
    """Ask for GUIDED and to arm until a heartbeat shows both."""
    end_s = time.monotonic() + _LONGEST_S
    while time.monotonic() < end_s:
        vehicle.request_mode("GUIDED")
        vehicle.request_arm()
        if Heartbeat("GUIDED", True) in vehicle.reports(1.0):
            return
    pytest.fail("the copter does not arm")
