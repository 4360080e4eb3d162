"""The first legs of a mission after a take-off, against a real ArduCopter 4.6 (SITL, by its own log)."""

import numpy as np
import pytest

from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.mission.items import Home, Mission, change_speed, waypoint
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.flight.trajectory import simulate

PLACES_M = [
    (0.000, 0.000),
    (0.042, -0.284),
    (0.175, -1.175),
    (1.177, -2.464),
    (2.850, -3.396),
    (4.457, -3.718),
    (5.154, -2.791),
]
SPEEDS_M_S = [1.29, 0.95, 1.67, 2.5, 3.69, 3.69]
REACHED_AFTER_S = [1.025, 1.61, 1.458, 1.127]


def test_the_first_legs_after_a_climb_take_as_long_as_in_truth() -> None:
    """Four short splines from rest: as a whole within 0.1 s of 5.22 s; without the slow start it is 4.85."""
    frame = FlatFrame(-35.36228, 149.1656837)
    (lat, *lats), (lon, *lons) = (each.tolist() for each in frame.to_degrees(np.array(PLACES_M)))
    items = [waypoint(lat, lon, 30.0, hold_s=1.0, spline=False)]
    for speed, north, east in zip(SPEEDS_M_S, lats, lons, strict=True):
        items += [change_speed(speed), waypoint(north, east, 30.0, spline=True)]
    mission = Mission(tuple(items), Home(lat, lon, 590.7))
    flown = simulate(mission, Limits(), start_m=(0.0, 0.0, 28.5), velocity_m_s=(0.0, 0.0, 1.2))
    passed_s = [flown.reached_s[seq] for seq, _ in mission.waypoints]
    assert passed_s[4] - passed_s[0] == pytest.approx(sum(REACHED_AFTER_S), abs=0.1)
