"""Whole missions in the model: trajectories, whole flights, and what ArduCopter's recordings show."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from flight_replay.exceptions import MissionError
from flight_replay.geometry.matching import match_in_order
from flight_replay.mission.formats import load_mission
from flight_replay.mission.items import Frame, Home, Mission, MissionItem, change_speed, waypoint
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.simulated_draft import simulate_draft
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.flight.trajectory import home_frame, simulate, simulate_flight
from tests.helpers.made_missions import KINDS, mission_at, random_mission
from tests.helpers.paths import ARDUCOPTER, EXAMPLES

LIMITS = Limits()
RECORDED = sorted(path.stem for path in ARDUCOPTER.glob("*.waypoints"))
EXAMPLE = EXAMPLES / "simulate_mission.py"
SQUARE = ((40.0, 0.0, 20.0), (40.0, 40.0, 20.0), (0.0, 40.0, 20.0), (0.0, 0.0, 20.0))


def test_an_item_that_is_not_simulated_is_named() -> None:
    """A mission is not flown as if it were another."""
    mission = mission_at(SQUARE)
    climb = MissionItem(31, Frame.RELATIVE, (0.0,) * 4, 47.0, 8.0, 40.0)
    with pytest.raises(MissionError, match=r"Item 5 \(command 31\) cannot be simulated"):
        simulate(Mission((*mission.items, climb), mission.home), LIMITS)


def test_a_trajectory_has_a_row_per_step_and_the_start() -> None:
    """Time runs evenly from AUTO's beginning, the first row is the start, and every item has its time."""
    flown = simulate(mission_at(SQUARE), LIMITS)
    assert flown.auto_s[0] == flown.time_s[0] == 0.0
    assert np.diff(flown.time_s) == pytest.approx(0.02)
    assert flown.time_s[-1] == flown.auto_s[1]
    assert flown.north_east_m[0] == pytest.approx([0.0, 0.0], abs=1e-6)
    assert flown.up_m[0] == 20.0
    assert list(flown.reached_s) == [1, 2, 3, 4]
    assert np.hypot(flown.north_m_s, flown.east_m_s).max() < 7.5


def test_positions_are_ground_metres_around_home() -> None:
    """A leg of 500 ground metres ends there, though ArduPilot flies in metres of its own."""
    home = Home(64.1, -21.9, 20.0)
    frame = home_frame(Mission((), home))
    lat, lon = frame.to_degrees((300.0, 400.0))
    flown = simulate(Mission((waypoint(float(lat), float(lon), 20.0),), home), LIMITS, step_s=0.04)
    assert flown.north_east_m[-1] == pytest.approx([300.0, 400.0], abs=1.5)


@pytest.mark.parametrize("kind", KINDS)
def test_the_step_changes_next_to_nothing(kind: str) -> None:
    """Steps of 10 and 40 ms fly the same path in the same time."""
    mission = random_mission(12 + KINDS.index(kind))
    fine, coarse = (simulate(mission, LIMITS, step_s=step) for step in (0.01, 0.04))
    assert coarse.auto_s[1] == pytest.approx(fine.auto_s[1], rel=0.004, abs=0.2)
    assert match_in_order(fine.north_east_m[::20], coarse.north_east_m).distance_m.mean() < 0.05


def _winding_mission(seed: int) -> Mission:
    """Splines through sharp turns, a speed of its own for each."""
    chance = np.random.default_rng(seed)
    course, legs_m = np.cumsum(chance.normal(0.0, 1.0, 20)), 6.0 * np.exp(chance.normal(0.0, 0.4, 20))
    north_m, east_m = (np.cumsum(legs_m * along(course)).tolist() for along in (np.cos, np.sin))
    places = mission_at([(n, e, 20.0) for n, e in zip(north_m, east_m, strict=True)], spline=True)
    items = [(change_speed(round(chance.uniform(0.5, 8.0), 2)), item) for item in places.items]
    return Mission(tuple(item for pair in items for item in pair), places.home)


@pytest.mark.parametrize("seed", [0, 3, 4])
def test_splines_take_as_long_whatever_the_step_and_where_steps_fall(seed: int) -> None:
    """A row of bends is flown in steps of 20 ms as on board; 10 micrometres to the side cost no time.

    Where the speed had to turn between two steps, such a flight was up to 0.1 s off after 80 s.
    """
    random = np.random.default_rng(seed)
    course_rad, steps_m = np.cumsum(random.uniform(-1.2, 1.2, 25)), random.uniform(6.0, 18.0, 25)
    places = np.column_stack(
        [np.cumsum(steps_m * np.cos(course_rad)), np.cumsum(steps_m * np.sin(course_rad)), np.full(25, 30.0)]
    )
    curves, no_waits, same_speed = np.arange(25) > 0, np.zeros(25), np.full(25, np.nan)
    aside = [np.zeros((25, 3)), *(random.normal(0.0, 1e-5, (25, 3)) for _ in range(4))]
    drafts = [Draft(places + each, curves, no_waits, same_speed) for each in aside]
    on_board = simulate_draft(drafts[0], LIMITS, 0.0025).passed_s
    passed_s = np.array([simulate_draft(draft, LIMITS, 0.02).passed_s for draft in drafts])
    assert passed_s[0] == pytest.approx(on_board, abs=0.05)
    assert np.ptp(passed_s[:, :-1], axis=0).max() < 0.002


def test_long_steps_are_not_ahead_in_sharp_turns() -> None:
    """Over many legs what steps of 20 ms lose and gain against those of the autopilot makes up for it."""
    ahead_s = []
    for seed in range(8):
        fine, coarse = (
            simulate(_winding_mission(seed), LIMITS, step_s=step).reached_s for step in (0.0025, 0.02)
        )
        ahead_s.append(np.mean([fine[seq] - coarse[seq] for seq in fine.keys() & coarse.keys()]))
    assert abs(np.mean(ahead_s)) < 0.02


def test_part_of_a_mission_may_be_flown_from_anywhere() -> None:
    """Started at item 3 with position and velocity of the whole flight there, the rest is the same."""
    mission = mission_at([(0, 30, 20), (60, 30, 20), (60, 100, 20), (0, 100, 20), (0, 150, 20)])
    whole = simulate(mission, LIMITS)
    k = int(np.searchsorted(whole.time_s, whole.reached_s[2]))
    start = (float(whole.north_m[k]), float(whole.east_m[k]), float(whole.up_m[k]))
    velocity = (float(whole.north_m_s[k]), float(whole.east_m_s[k]), 0.0)
    part = simulate(mission, LIMITS, start_m=start, velocity_m_s=velocity, start_seq=3)
    assert list(part.reached_s) == [3, 4, 5]
    assert part.auto_s[1] == pytest.approx(whole.auto_s[1] - whole.reached_s[2], abs=2.5)
    assert match_in_order(part.north_east_m[500:], whole.north_east_m[k:]).distance_m.max() < 0.5


def test_a_whole_flight_takes_off_flies_returns_and_lands() -> None:
    """From arming to disarming at home, with AUTO begun at 95 % of the take-off altitude."""
    flown = simulate_flight(mission_at(SQUARE), LIMITS, after_s=4.0)
    begin = int(np.searchsorted(flown.time_s, flown.auto_s[0]))
    assert flown.up_m[begin] == pytest.approx(19.0, abs=0.1)
    assert flown.up_m[-1] == 0.0
    assert np.hypot(flown.north_m[-1], flown.east_m[-1]) < 0.2
    assert flown.time_s[-1] - flown.auto_s[1] > 4.0 + 30.0
    low = simulate_flight(mission_at(SQUARE), LIMITS, takeoff_m=10.0)
    assert low.auto_s[0] < flown.auto_s[0] - 3.0


def test_parameters_change_durations_as_they_do_on_board() -> None:
    """Slower, softer and tighter limits each take longer, a wider radius less."""
    mission = mission_at(SQUARE)

    def seconds(**parameters: float) -> float:
        return simulate(mission, Limits.from_parameters(parameters)).auto_s[1]

    plain = seconds()
    assert seconds(WPNAV_SPEED=500) > plain + 3
    assert seconds(WPNAV_ACCEL=100) > plain + 5
    assert seconds(WPNAV_RADIUS=500) < plain - 2
    assert seconds(WPNAV_JERK=5) < plain - 3
    assert seconds(WP_SPD=5.0) == seconds(WPNAV_SPEED=500)


def test_wind_changes_little_and_is_felt() -> None:
    """In 6 m/s of wind the path stays within decimetres of that in still air, but is not the same."""
    mission = mission_at(SQUARE)
    empty_segment, windy = simulate(mission, LIMITS), simulate(mission, LIMITS, wind_m_s=(0.0, 6.0, 0.0))
    off = match_in_order(windy.north_east_m[::10], empty_segment.north_east_m).distance_m
    assert 0.02 < off.max() < 2.0


def test_thin_air_lets_a_leaning_copter_fly_faster() -> None:
    """At full lean the real ArduCopter 4.6 flew 10.19 m/s where home was 400 m above the sea."""
    speeds = {}
    for home_amsl_m in (0.0, 400.0, 4000.0, 1e6):
        mission = mission_at([(20, 0, 20), (320, 0, 20)], home=Home(47.0, 8.0, home_amsl_m))
        flown = simulate(mission, Limits.from_parameters({"WPNAV_SPEED": 1500.0}))
        speeds[home_amsl_m] = float((np.diff(flown.north_east_m[:, 0]) / np.diff(flown.time_s)).max())
    assert speeds[400.0] == pytest.approx(10.19, abs=0.03)
    assert list(speeds.values()) == sorted(speeds.values())


def test_missions_that_cannot_be_flown_are_refused() -> None:
    """No location, no altitude, or no end: each is one sentence."""
    with pytest.raises(MissionError, match="neither home nor waypoint"):
        simulate(Mission(()), LIMITS)
    with pytest.raises(MissionError, match="altitude"):
        simulate(Mission((change_speed(3.0),), Home(47, 8, 0)), LIMITS)
    jump = MissionItem(177, Frame.MISSION, (1.0, -1.0, 0.0, 0.0), 0.0, 0.0, 0.0)
    endless = Mission((*mission_at(SQUARE[:1]).items, jump), Home(47.0, 8.0, 400.0))
    with pytest.raises(MissionError, match="does not end"):
        simulate(endless, LIMITS, step_s=0.5)


def test_a_mission_without_home_is_flown_around_its_first_waypoint() -> None:
    """The frame's origin is then the first waypoint, and so is the start."""
    mission = Mission(mission_at(SQUARE).items)
    flown = simulate(mission, LIMITS)
    assert flown.north_east_m[0] == pytest.approx([0.0, 0.0], abs=1e-6)
    assert list(flown.reached_s) == [1, 2, 3, 4]


def test_the_example_says_how_long_a_mission_takes(tmp_path: Path) -> None:
    """examples/simulate_mission.py runs as it stands, and takes a file and parameters."""
    path = tmp_path / "line.waypoints"
    rows = ["0\t1\t0\t16\t0\t0\t0\t0\t47\t8\t400\t1", "1\t0\t3\t16\t0\t0\t0\t0\t47.001\t8\t20\t1"]
    path.write_text("QGC WPL 110\n" + "\n".join(rows) + "\n")
    plain, slow = (
        subprocess.run(
            [sys.executable, "-W", "error", str(EXAMPLE), *more], capture_output=True, text=True, check=True
        )
        for more in ((), (str(path), "WPNAV_SPEED=200"))
    )
    assert "AUTO takes 3" in plain.stdout
    assert "at up to 2.0 m/s" in slow.stdout


@pytest.mark.parametrize("name", RECORDED)
def test_recordings_of_arducopter_are_met(name: str) -> None:
    """In space mean 0.15 and max 0.6 m, AUTO within 2 %, take-off and RTL within 5 %."""
    mission = load_mission(ARDUCOPTER / f"{name}.waypoints")
    with (ARDUCOPTER / f"{name}.csv").open() as file:
        rows = [{key: int(value) for key, value in row.items()} for row in csv.DictReader(file)]
    story = json.loads((ARDUCOPTER / f"{name}.json").read_text())
    begin, end = story["auto_start_ms"], max(t for t, _ in story["reached"])
    returning = next(row["time_boot_ms"] for row in rows if row["mode"] == 6)
    disarmed = next(t for t, text in story["text"] if "Disarming" in text)
    flown = simulate_flight(mission, LIMITS, after_s=(returning - end) * 1e-3)
    auto = [row for row in rows if begin <= row["time_boot_ms"] <= end]
    places = home_frame(mission).to_metres(
        [row["lat_e7"] * 1e-7 for row in auto], [row["lon_e7"] * 1e-7 for row in auto]
    )
    path = flown.north_east_m[(flown.time_s >= flown.auto_s[0]) & (flown.time_s <= flown.auto_s[1] + 1.0)]
    off = match_in_order(places, path).distance_m
    assert off.mean() <= 0.15
    assert off.max() <= 0.6
    ours = flown.auto_s[1] - flown.auto_s[0]
    assert ours == pytest.approx((end - begin) * 1e-3, rel=0.02)
    assert flown.auto_s[0] == pytest.approx((begin - rows[0]["time_boot_ms"]) * 1e-3, rel=0.05)
    home = flown.time_s[-1] - flown.auto_s[1] - (returning - end) * 1e-3
    assert home == pytest.approx((disarmed - returning) * 1e-3, rel=0.05)
