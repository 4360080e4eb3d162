"""json_summary.py: the objects of ``--json``."""

import json
import re
from dataclasses import replace

import pytest

from flight_replay.output.json_summary import flight_summary, route_summary
from flight_replay.output.outcome import compare_flight
from flight_replay.planning.heights import HeightChange, RouteHeights
from flight_replay.planning.vehicle_limits import VehicleLimits
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.made_replays import made_following, made_replay


def test_items_are_numbered_from_1_without_home() -> None:
    """Sequence numbers are those on board, where home is item 0."""
    route, _ = made_replay()
    summary = route_summary(route)
    count = len(route.mission.items)
    assert [item["seq"] for item in summary["items"]] == list(range(1, count + 1))
    assert (summary["method"], summary["points"]) == ("spacing", count)


def test_items_are_as_precise_as_on_board() -> None:
    """No noise of floats, and no -0.0."""
    route, _ = made_replay()
    first = replace(
        route.mission.items[0], params=(0.1 + 0.2, -1e-9, 0.0, 0.0),
        lat_deg=47.1 + 0.2 + 1e-12, lon_deg=-1e-9, alt_m=-0.001,
    )  # fmt: skip
    mission = replace(route.mission, items=(first, *route.mission.items[1:]))
    item = route_summary(replace(route, mission=mission))["items"][0]
    told = [item["params"], item["lat_deg"], item["lon_deg"], item["alt_m"]]
    assert json.dumps(told) == "[[0.3, 0.0, 0.0, 0.0], 47.3, 0.0, 0.0]"


def test_errors_that_do_not_exist_are_null() -> None:
    """A flight that reached no waypoint has no error; its keys stay, and the reason is there."""
    route, outcome = made_replay()
    record = outcome.record
    record = replace(record, reached=())
    summary = flight_summary("ArduCopter V4.6.0", True, compare_flight(route, record))
    nothing = {"mean": None, "p95": None, "max": None}
    assert summary["position_error_m"] == summary["height_error_m"] == nothing
    assert summary["path_error_m"] == {"recorded_to_flown": nothing, "flown_to_recorded": nothing}
    assert summary["heading_error_deg"] is None
    assert summary["alignment"]["flown_s"] is None
    assert set(summary["not_measured"].values()) == {"the first waypoint was not reached"}
    assert summary["coverage"]["fixes"] == 0
    assert (summary["vehicle"], summary["simulated"], summary["ended"]) == (
        "ArduCopter V4.6.0",
        True,
        "duration",
    )


def test_the_alignment_and_the_coverage_are_told() -> None:
    """What was put on what, how many fixes were compared, and how much of the recording was flown."""
    route, outcome = made_replay()
    summary = flight_summary("ArduCopter V4.6.0", True, outcome)
    assert summary["alignment"]["flown_s"] == 1002.0
    assert summary["alignment"]["recorded_s"] == 0.0
    assert summary["alignment"]["fixes"] == len(outcome.errors.position_m)
    assert summary["alignment"]["headings"] == 0
    assert summary["not_measured"] == {"heading_error_deg": "one of both flights has no heading"}
    coverage = summary["coverage"]
    assert 0 < coverage["fixes"] < coverage["of_fixes"] == len(route.recording)
    assert coverage["to_fly_all"] == ["--duration all"]


def test_a_route_that_cannot_be_predicted_says_so() -> None:
    """No prediction is null; a fit has its objective."""
    route, _ = made_replay()
    assert route_summary(route)["predicted"] is None
    assert route_summary(route)["heights"] is None
    assert "objective_m" not in route_summary(route)
    assert route_summary(replace(route, objective_m=1.25))["objective_m"] == 1.25


def test_the_limits_of_a_plan_are_told() -> None:
    """Always, in m/s, m/s², m/s³, m and degrees; those of no vehicle are the defaults of ArduCopter 4.6."""
    route, _ = made_replay()
    assert route_summary(route)["limits"] == {
        "vehicle": None,
        "speed_m_s": 10.0,
        "accel_m_s2": 2.5,
        "accel_corner_m_s2": 5.0,
        "jerk_m_s3": 1.0,
        "radius_m": 2.0,
        "speed_up_m_s": 2.5,
        "speed_down_m_s": 1.5,
        "accel_z_m_s2": 1.0,
        "yaw_behavior": 2.0,
        "shaping_jerk_m_s3": 5.0,
        "lean_angle_deg": 30.0,
        "lean_accel_deg_s2": pytest.approx(1100.0),
        "lean_rate_deg_s": 0.0,
        "attitude_input_s": 0.15,
        "position_p": 1.0,
        "velocity_p": 2.0,
        "velocity_i": 1.0,
        "velocity_d": 0.5,
        "velocity_error_hz": 5.0,
        "velocity_d_hz": 5.0,
        "position_z_p": 1.0,
        "velocity_z_p": 5.0,
        "yaw_slew_deg_s": pytest.approx(60.0),
        "yaw_accel_deg_s2": pytest.approx(270.0),
        "mount_type": 0.0,
    }
    told = replace(route, limits=VehicleLimits(Limits(wp_speed_m_s=4.0), "ArduCopter 4.6.0"))
    assert route_summary(told)["limits"]["speed_m_s"] == 4.0
    assert route_summary(told)["limits"]["vehicle"] == "ArduCopter 4.6.0"


def test_heights_have_their_own_object() -> None:
    """The climb to the first waypoint is negative for a descent; changes have a count and a maximum."""
    route, _ = made_replay()
    raised, none = HeightChange(12, 3.25), HeightChange(0, 0.0)
    heights = RouteHeights(30.0, 5.0, 18.0, 5.0, raised, none, ("words",))
    assert route_summary(replace(route, heights=heights))["heights"] == {
        "takeoff_m": 30.0,
        "first_waypoint_m": 5.0,
        "climb_to_first_m": -25.0,
        "climb_to_first_s": 18.0,
        "floor_m": 5.0,
        "raised_to_floor": {"fixes": 12, "max_m": 3.25},
        "not_kept": {"fixes": 0, "max_m": 0.0},
    }


def test_a_motion_that_is_followed_has_its_own_object() -> None:
    """Instead of items; the flight says how long the recording waited."""
    route, outcome = made_following(waits_at_s=40.0, waits_s=7.0)
    summary = route_summary(route)
    assert (summary["method"], summary["points"], summary["items"]) == ("guided", 0, [])
    motion = summary["reference"]
    assert motion["duration_s"] == pytest.approx(summary["predicted_duration_s"] + 5.0, abs=0.3)
    assert motion["lowest_m"] == motion["highest_m"] == 30.0
    assert 3.0 < motion["top_speed_m_s"] < 6.0
    assert "reference" not in route_summary(made_replay()[0])
    alignment = flight_summary("ArduCopter V4.6.0", True, outcome)["alignment"]
    assert alignment["waited_s"] == 7.0
    assert alignment["flown_s"] == 1005.0


def test_a_small_negative_number_is_written_as_zero() -> None:
    """Not as -0.0, such as the descent of a motion at one height."""
    route, _ = made_following()
    level = route_summary(replace(route, predicted_duration_s=-0.0001))
    assert "-0.0" not in re.findall(r"-?[\d.]+", json.dumps(level))
