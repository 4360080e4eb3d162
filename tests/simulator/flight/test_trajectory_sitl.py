"""The model against a real ArduCopter, on missions of its own making.

SITL_BINARY names the ArduCopter (4.1 or later), SITL_DEFAULTS_FILEPATH its default_params/copter.parm.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from flight_replay.geometry.flight_errors import errors_at_equal_times
from flight_replay.geometry.matching import match_in_order
from flight_replay.geometry.movement import Movement
from flight_replay.mission.items import Mission
from flight_replay.planning.vehicle_limits import limits_of
from flight_replay.simulator.flight.trajectory import home_frame, simulate_flight
from tests.helpers.made_missions import mission_at, random_mission
from tests.helpers.sitl_flight import SitlFlight

BINARY, DEFAULTS = os.environ.get("SITL_BINARY", ""), os.environ.get("SITL_DEFAULTS_FILEPATH", "")
pytestmark = [
    pytest.mark.sitl,
    pytest.mark.skipif(
        not (BINARY and DEFAULTS), reason="SITL_BINARY and SITL_DEFAULTS_FILEPATH are not set"
    ),
]
SQUARE = mission_at([(40.0, 0.0, 20.0), (40.0, 40.0, 20.0), (0.0, 40.0, 20.0), (0.0, 0.0, 20.0)])
AT_LEAST = {"WPNAV_SPEED": 1000.0, "WPNAV_JERK": 1.0}
# The position estimate's noise decides how soon a leg from rest gets going, by 0.1 s each; after a
# curve that began where AUTO did, and not at a waypoint, so do rounding errors, by 0.6 s.
SHORTEST_NOISE_S = 0.8


def check(mission: Mission, parameters: dict[str, float], folder: Path) -> None:
    """Fly it there and here; assert that they agree."""
    assert mission.home is not None
    with SitlFlight(Path(BINARY), Path(DEFAULTS), folder, mission.home, parameters) as there:
        truth = there.fly(mission)
        told = limits_of({**AT_LEAST, **there.parameters}, "ArduCopter", there.version)
    assert told is not None
    rows = np.array(truth.rows)
    last_s = max(truth.reached_s.values())
    flown = simulate_flight(mission, told.limits, after_s=truth.rtl_s - last_s)
    auto = (rows[:, 0] >= truth.auto_s) & (rows[:, 0] <= last_s)
    places = home_frame(mission).to_metres(rows[auto, 1], rows[auto, 2])
    own = (flown.time_s >= flown.auto_s[0]) & (flown.time_s <= flown.auto_s[1] + 1.0)
    off = match_in_order(places, flown.north_east_m[own]).distance_m
    first = min(truth.reached_s)
    unknown = np.full(len(places), np.nan)
    recorded = Movement(rows[auto, 0] - truth.reached_s[first], places, unknown, unknown)
    simulated = Movement(
        flown.time_s - flown.reached_s[first], flown.north_east_m, flown.up_m, flown.heading_deg
    )
    late = errors_at_equal_times(recorded, simulated.select(own))[0].error
    theirs, ours = last_s - truth.auto_s, flown.auto_s[1] - flown.auto_s[0]
    takeoff_s, home_s = truth.high_s - truth.armed_s, truth.disarmed_s - truth.rtl_s
    assert off.mean() <= 0.15
    assert off.max() <= 0.6
    assert late.mean() <= 0.75
    assert ours == pytest.approx(theirs, rel=0.02, abs=SHORTEST_NOISE_S)
    assert flown.auto_s[0] == pytest.approx(takeoff_s, rel=0.05)
    assert flown.time_s[-1] - flown.auto_s[1] - (truth.rtl_s - last_s) == pytest.approx(home_s, rel=0.05)


@pytest.mark.parametrize("seed", range(20, 30))
def test_random_missions_fly_alike(seed: int, tmp_path: Path) -> None:
    """Straight, spline and mixed missions with legs of 1 to 100 m, speeds, delays and climbs."""
    check(random_mission(seed), {}, tmp_path)


@pytest.mark.parametrize(
    "parameters",
    [
        {"WPNAV_SPEED": 500.0},
        {"WPNAV_ACCEL": 100.0},
        {"WPNAV_RADIUS": 500.0},
        {"WPNAV_JERK": 5.0, "WPNAV_ACCEL_C": 200.0},
        {"RTL_SPEED": 300.0, "LAND_SPEED": 80.0, "RTL_LOIT_TIME": 1000.0},
    ],
    ids="+".join,
)
def test_parameters_change_the_flight_alike(parameters: dict[str, float], tmp_path: Path) -> None:
    """What WPNAV, RTL and LAND parameters change there, they change here."""
    check(SQUARE, parameters, tmp_path)


DOUBLED = mission_at([(30, 0, 20), (30, 0, 20), (30, 30, 20), (30, 30, 20), (0, 30, 20)], spline=True)
BACK = mission_at([(50, 0, 20), (0, 0, 20), (50, 0, 20), (20, 0, 20)], spline=True)


STEPS = mission_at([(0, 0, 20), (0, 0, 40), (20, 0, 40), (20, 0, 20), (40, 0, 20), (40, 0, 40), (40, 0, 60)])


@pytest.mark.parametrize("mission", [DOUBLED, BACK, STEPS], ids=["doubled", "there and back", "steps"])
def test_odd_missions_fly_alike(mission: Mission, tmp_path: Path) -> None:
    """Splines without length, splines straight back, and climbs straight up, whose corners are by version."""
    check(mission, {}, tmp_path)


def test_as_fast_as_full_lean_allows_they_fly_alike(tmp_path: Path) -> None:
    """Beyond some 10 m/s it is the drag of the air at that height that sets the speed."""
    far = mission_at([(20, 0, 20), (320, 0, 20), (320, 200, 20), (0, 200, 20)])
    check(far, {"WPNAV_SPEED": 1500.0}, tmp_path)
