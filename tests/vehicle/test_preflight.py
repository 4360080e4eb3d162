"""What must not be flown is refused before the upload, and the briefing describes what will be flown."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.events import VehicleState
from flight_replay.exceptions import FlightReplayError, MissionError, VehicleError
from flight_replay.mission.items import Frame, Home, Mission, MissionItem, change_speed, waypoint
from flight_replay.vehicle.identity import Identity
from flight_replay.vehicle.preflight import MAX_DISTANCE_M, check
from flight_replay.vehicle.route_words import MotionWords

COPTER = Identity(
    system=1, vehicle_type=2, autopilot=3, version="4.6.0", takes_item_int=True, simulated=False
)
HERE = VehicleState(1.0, 47.0, 8.0, 0.0, (0, 0, 0), None, "STABILIZE", False, 12.3, 77.0)
STEP_DEG = 9e-5  # 10 m of latitude.
FENCE = {"FENCE_ENABLE": 1.0, "FENCE_TYPE": 15.0, "FENCE_RADIUS": 150.0, "FENCE_ALT_MAX": 100.0,
         "FENCE_ALT_MIN": -10.0, "FENCE_MARGIN": 2.0}  # fmt: skip


def route(*steps: int, alt_m: float = 30.0) -> Mission:
    """Waypoints so many times 10 m north, with a change of speed between."""
    items: list[MissionItem] = [change_speed(3.0)]
    items += [waypoint(47.0 + STEP_DEG * step, 8.0, alt_m) for step in steps]
    return Mission(tuple(items))


def checked(mission: Mission, identity: Identity = COPTER, max_distance_m: float = MAX_DISTANCE_M) -> object:
    return check(identity, mission, HERE, takeoff_altitude_m=30.0, max_distance_m=max_distance_m)


def test_the_briefing_describes_vehicle_and_route() -> None:
    """Vehicle, position, battery, distance to the first waypoint, and the route's extent."""
    briefing = check(COPTER, route(1, 5, 12, alt_m=42.0), HERE, takeoff_altitude_m=30.0)
    assert briefing.lines == (
        "Vehicle: ArduCopter 4.6.0 (quadcopter, system 1)",
        "Position: 47.0000000, 8.0000000",
        "Battery: 12.3 V, 77 %",
        "First waypoint: 10 m away",
        "Route: 3 waypoints, up to 120 m away and 42 m above home",
    )


def test_an_unknown_battery_is_unknown_in_the_briefing() -> None:
    """A vehicle without a battery monitor."""
    at = replace(HERE, battery_v=None, battery_percent=None)
    assert check(COPTER, route(1), at, takeoff_altitude_m=30.0).lines[2] == "Battery: unknown"


@pytest.mark.parametrize(
    ("parameters", "why"),
    [
        ({"FS_GCS_ENABLE": 0.0, "SYSID_MYGCS": 255.0}, "FS_GCS_ENABLE is 0"),
        ({"FS_GCS_ENABLE": 1.0, "SYSID_MYGCS": 254.0}, "SYSID_MYGCS is 254, not 255"),
        ({"FS_GCS_ENABLE": 1.0, "MAV_GCS_SYSID": 1.0}, "MAV_GCS_SYSID is 1, not 255"),
        ({"FS_GCS_ENABLE": 1.0, "MAV_GCS_SYSID": 1.0, "MAV_GCS_SYSID_HI": 255.0}, ""),
        ({"FS_GCS_ENABLE": 2.0}, "FS_GCS_ENABLE is 2"),
        ({"FS_GCS_ENABLE": 1.0, "FS_OPTIONS": 18.0}, "FS_OPTIONS is 18: AUTO goes on"),
        ({"FS_GCS_ENABLE": 1.0, "FS_OPTIONS": 16.0}, ""),
        ({"FS_GCS_ENABLE": 1.0, "SYSID_MYGCS": 255.0}, ""),
        ({}, ""),
    ],
)
def test_the_briefing_names_a_failsafe_that_does_not_act(parameters: dict[str, float], why: str) -> None:
    """ArduCopter's is off by default, and counts the heartbeats of one system id."""
    identity = replace(COPTER, parameters=parameters)
    lines = check(identity, route(1), HERE, takeoff_altitude_m=30.0).lines[5:]
    assert lines == ((f"Lost link: the vehicle does not come home by itself ({why})",) if why else ())


def test_in_guided_the_failsafe_acts_that_does_not_in_auto() -> None:
    """Options that let a mission go on are of AUTO alone."""
    identity = replace(COPTER, parameters={"FS_GCS_ENABLE": 1.0, "FS_OPTIONS": 2.0})
    words = MotionWords(np.zeros(2))
    assert len(check(identity, route(1), HERE, takeoff_altitude_m=30.0, words=words).lines) == 5


def test_a_far_away_first_waypoint_is_refused() -> None:
    """1000 m by default, or what was asked for."""
    with pytest.raises(MissionError, match=r"1101 m from the vehicle, more than 1000 m; .*--max-distance"):
        checked(route(110))
    checked(route(110), max_distance_m=1200.0)
    checked(route(1, 200))


@pytest.mark.parametrize(("lat_deg", "lon_deg"), [(-47.0, -172.0), (-35.36, 149.16)])
def test_the_other_side_of_the_earth_is_far_away(lat_deg: float, lon_deg: float) -> None:
    """Not near, as in the plane of a local frame."""
    with pytest.raises(MissionError, match=r"is 12\d{6} m from the vehicle"):
        checked(Mission((waypoint(lat_deg, lon_deg, 30.0),)), max_distance_m=1e7)


def test_the_distance_is_measured_across_the_antimeridian() -> None:
    """179.9999 and -179.9999 degrees are metres apart."""
    at = replace(HERE, lat_deg=10.0, lon_deg=179.9999)
    mission = Mission((waypoint(10.0, -179.9999, 30.0),))
    assert check(COPTER, mission, at, takeoff_altitude_m=30.0).first_m == pytest.approx(21.9, abs=0.1)


OTHERS = {
    "plane": (replace(COPTER, vehicle_type=1), r"fixed wing, system 1\) is not a multicopter"),
    "rover": (replace(COPTER, vehicle_type=10), "ground rover"),
    "helicopter": (replace(COPTER, vehicle_type=4), "helicopter"),
    "PX4": (replace(COPTER, autopilot=12), "unknown firmware"),
    "newer type": (replace(COPTER, vehicle_type=250), "vehicle, system 1"),
}


@pytest.mark.parametrize(("identity", "words"), OTHERS.values(), ids=OTHERS.keys())
def test_anything_but_a_multicopter_is_refused(identity: Identity, words: str) -> None:
    """The error names the vehicle."""
    with pytest.raises(VehicleError, match=words):
        checked(route(1), identity)


def test_an_armed_vehicle_is_left_alone() -> None:
    """Its mission may be the one that it flies: nothing is uploaded."""
    with pytest.raises(VehicleError, match="already armed, in mode AUTO"):
        check(COPTER, route(1), replace(HERE, armed=True, mode="AUTO"), takeoff_altitude_m=30.0)


@pytest.mark.parametrize("vehicle_type", [2, 13, 14, 15, 29, 35])
def test_multicopters_of_any_number_of_rotors_are_flown(vehicle_type: int) -> None:
    """From three to twelve rotors."""
    checked(route(1), replace(COPTER, vehicle_type=vehicle_type, simulated=True))


def odd(frame: int = Frame.RELATIVE, lat_deg: float = 47.0, alt_m: float = 30.0) -> Mission:
    return Mission((MissionItem(16, frame, (0, 0, 0, 0), lat_deg, 8.0, alt_m),))


UNFLYABLE = {
    "frame": (odd(frame=1), "altitude frame 1"),
    "no number": (odd(alt_m=float("nan")), "invalid coordinates"),
    "latitude": (odd(lat_deg=90.5), "invalid coordinates"),
    "on the ground": (odd(alt_m=0.0), "fly higher with --altitude"),
    "below home": (odd(alt_m=-3.0), "at -3 m above home"),
}


@pytest.mark.parametrize(("mission", "words"), UNFLYABLE.values(), ids=UNFLYABLE.keys())
def test_invalid_waypoints_are_refused(mission: Mission, words: str) -> None:
    """Altitude 0 means "keep the altitude" to ArduCopter, and it does not support other frames."""
    with pytest.raises(MissionError, match=words):
        checked(mission)


BEYOND = {
    "radius": (
        route(1, 15),
        FENCE,
        r"150 m from the vehicle, outside the vehicle's fence \(FENCE_RADIUS 150 m",
    ),
    "ceiling": (
        route(1, alt_m=99.0),
        FENCE,
        r"route reaches 99 m above home.* \(FENCE_ALT_MAX 100 m, margin 2 m\); fly lower with --altitude,",
    ),
    "floor": (
        route(1, alt_m=29.5),
        FENCE | {"FENCE_ALT_MIN": 28.0},
        r"FENCE_ALT_MIN 28 m.*; fly higher with --altitude,",
    ),
    "take-off": (
        route(1, alt_m=10.0),
        FENCE | {"FENCE_ALT_MAX": 25.0},
        "the take-off reaches 30 m above home.*; fly lower with --takeoff-altitude,",
    ),
}


@pytest.mark.parametrize(("mission", "fence", "words"), BEYOND.values(), ids=BEYOND.keys())
def test_a_route_beyond_the_fence_is_refused(mission: Mission, fence: dict[str, float], words: str) -> None:
    """Radius, ceiling and floor count with their margin, for the take-off too."""
    with pytest.raises(MissionError, match=words):
        checked(mission, replace(COPTER, parameters=fence))


def test_a_fence_that_is_enabled_by_arming_counts() -> None:
    """FENCE_AUTOENABLE of ArduCopter 4.6."""
    fence = FENCE | {"FENCE_ENABLE": 0.0, "FENCE_AUTOENABLE": 3.0}
    with pytest.raises(MissionError, match="FENCE_RADIUS 150 m"):
        checked(route(1, 15), replace(COPTER, parameters=fence))


@pytest.mark.parametrize("name", ["FENCE_ENABLE", "FENCE_TYPE", "FENCE_ALT_MAX", "FENCE_MARGIN"])
@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_an_invalid_fence_is_an_error(name: str, value: float) -> None:
    """NaN in the storage must not pass for a disabled fence."""
    with pytest.raises(VehicleError, match=f"{name} is {value:g}"):
        checked(route(1), replace(COPTER, parameters=FENCE | {name: value}))


@pytest.mark.parametrize(
    "fence",
    [{}, FENCE | {"FENCE_ENABLE": 0.0}, FENCE | {"FENCE_TYPE": 4.0}],
    ids=["none", "off", "of another kind"],
)
def test_a_disabled_fence_refuses_nothing(fence: dict[str, float]) -> None:
    """Only enabled fences of the types that are set count."""
    checked(route(1, 40, alt_m=200.0), replace(COPTER, parameters=fence))


@pytest.mark.parametrize(("parameters", "loiter_s"), [({"RTL_LOIT_TIME": 90_000.0}, 90.0), ({}, 5.0)])
def test_how_long_rtl_waits_over_home_is_the_vehicles(parameters: dict[str, float], loiter_s: float) -> None:
    """ArduCopter's default where it does not tell."""
    assert replace(COPTER, parameters=parameters).rtl_loiter_s == loiter_s


@pytest.mark.parametrize(
    ("parameters", "limit_m"),
    [
        ({}, 0.0),
        ({"RALLY_TOTAL": 0.0, "RALLY_LIMIT_KM": 0.3}, 0.0),
        ({"RALLY_TOTAL": 2.0, "RALLY_LIMIT_KM": 0.3}, 300.0),
        ({"RALLY_TOTAL": 2.0, "RALLY_LIMIT_KM": 0.0}, float("inf")),
    ],
)
def test_how_far_rally_points_may_be_is_the_vehicles(parameters: dict[str, float], limit_m: float) -> None:
    """ArduCopter goes to any, if its limit is 0."""
    assert replace(COPTER, parameters=parameters).rally_limit_m == pytest.approx(limit_m)


@pytest.mark.parametrize(("name", "value"), [("RTL_ALT_FINAL", 500.0), ("RTL_ALT_FINAL_M", 5.0)])
def test_a_landing_that_never_comes_is_not_waited_for(name: str, value: float) -> None:
    """RTL may end in the air: that is said before the vehicle arms, where its landing is asked for."""
    hovering = replace(COPTER, parameters={name: value})
    check(hovering, route(1), HERE, takeoff_altitude_m=30.0)
    check(replace(COPTER, parameters={name: 0.0}), route(1), HERE, takeoff_altitude_m=30.0, lands=True)
    with pytest.raises(VehicleError, match=f"would not land: {name} {value:g} .*; set it to 0, or leave out"):
        check(hovering, route(1), HERE, takeoff_altitude_m=30.0, lands=True)


def test_absolute_altitudes_are_measured_from_home() -> None:
    """A route in metres above sea level is compared with the fence above home."""
    mission = Mission(
        (MissionItem(16, Frame.ABSOLUTE, (0, 0, 0, 0), 47.0, 8.0, 530.0),), Home(47.0, 8.0, 500.0)
    )
    briefing = check(replace(COPTER, parameters=FENCE), mission, HERE, takeoff_altitude_m=10.0)
    assert briefing.highest_m == 30.0


def test_every_refusal_is_an_expected_error() -> None:
    """The command line prints it in one line."""
    with pytest.raises(FlightReplayError):
        checked(odd(frame=5))
