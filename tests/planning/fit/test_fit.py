"""The fit: few waypoints whose flown path follows a recording, in shape and in time."""

import tracemalloc
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from threadpoolctl import threadpool_info

from flight_replay.exceptions import LogError
from flight_replay.geometry.arrays import Floats
from flight_replay.logs.flights import select
from flight_replay.logs.read_log import read_log
from flight_replay.logs.track import Track
from flight_replay.mission.items import Command, speed_from_the_start
from flight_replay.mission.path import planned_path
from flight_replay.planning.fit import fit
from flight_replay.planning.fit.first_drafts.line_simplification import douglas_peucker, straight_draft
from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.reference import local_track
from flight_replay.planning.fit.simulated_draft import simulate_draft
from flight_replay.planning.spacing import decimate
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.flight.trajectory import simulate
from tests.helpers.fit_tracks import (
    FRAME,
    along,
    circle,
    draft_of,
    eights,
    hover,
    path_error,
    places_m,
    planned_error,
    position_error,
    predicted,
    recording_of,
    track_through,
    wander,
)
from tests.helpers.paths import SAMPLE, other_log


def distance_to_line_m(places: Floats, line: Floats) -> Floats:
    start, step = line[:-1], np.diff(line, axis=0)
    square = np.maximum((step**2).sum(axis=1), 1e-12)
    part = np.clip(((places[:, None] - start) * step).sum(axis=2) / square, 0, 1)
    return np.asarray(np.linalg.norm(places[:, None] - start - part[:, :, None] * step, axis=2).min(axis=1))


def rival_objectives_m(track: Track, max_points: int, *, timed: bool) -> list[float]:
    recording = local_track(track, 30.0)
    problem = problem_for(recording, max_points, Limits(), timed=timed)
    line = np.column_stack([recording.north_east_m, recording.up_m])
    return [
        problem.evaluate(straight_draft(recording, kept)).objective_m
        for kept in (douglas_peucker(line, max_points), decimate(track, max_points=max_points))
    ]


@pytest.mark.slow
@pytest.mark.usefixtures("brief_search")
def test_any_number_of_points_may_be_allowed() -> None:
    """The search takes no more than there are fixes to look at: 32,000 points took 12 GB."""
    tracemalloc.start()
    result = fit(wander(1), max_points=32_000)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(result.mission.waypoints) <= 1000
    assert peak < 500e6


@pytest.mark.usefixtures("brief_search")
def test_a_straight_flight_needs_two_points() -> None:
    """A straight_track at 15 m/s is one leg, flown on the line that was recorded."""
    result = fit(along([(0, 0), (300, 100)], 15.0))
    assert len(result.mission.waypoints) == 2
    assert planned_error(result).max < 0.01
    assert path_error(result).max < 0.3


@pytest.mark.usefixtures("brief_search")
def test_a_circle_needs_few_points_and_stays_round() -> None:
    """A circle takes fewer waypoints than the budget and stays within 0.5 m."""
    result = fit(circle(), max_points=60, speed_m_s="recorded")
    assert len(result.mission.waypoints) < 40
    assert path_error(result).mean < 0.3
    assert position_error(result).mean < 3.0


@pytest.mark.usefixtures("brief_search")
def test_recorded_speed_is_flown_at_recorded_speed() -> None:
    """A wandering flight takes as long as it was recorded, within 5 %, with few speed changes."""
    track = wander(1)
    result = fit(track, max_points=30, speed_m_s="recorded")
    assert result.predicted_duration_s == pytest.approx(track.time_s[-1], rel=0.05)
    commands = [item.command for item in result.mission.items]
    assert commands.count(Command.CHANGE_SPEED) < len(result.mission.waypoints)
    assert position_error(result).mean < 3.0


@pytest.mark.usefixtures("brief_search")
def test_what_is_predicted_is_what_the_model_flies() -> None:
    """The mission of the answer, flown in the model's finer steps, comes as near as was predicted."""
    result = fit(wander(2), max_points=30, speed_m_s="recorded")
    first = places_m(result)[0]
    air = simulate(result.mission, Limits(), start_m=(float(first[0]), float(first[1]), 30.0))
    begin_s = air.reached_s[result.mission.waypoints[0][0]]
    assert air.auto_s[1] - begin_s == pytest.approx(result.predicted_duration_s, rel=0.03)


@pytest.mark.usefixtures("brief_search")
def test_the_same_answer_every_time() -> None:
    """Two fits of one track are equal, item by item."""
    track = wander(3, fixes=40)
    assert fit(track, max_points=12).mission == fit(track, max_points=12).mission


@pytest.mark.usefixtures("brief_search")
def test_last_bits_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Other processors and libraries come to others, but to the same mission."""
    track, solve, interpolate = wander(3), np.linalg.solve, np.interp
    usual = fit(track, max_points=20, speed_m_s="recorded")
    monkeypatch.setattr(np.linalg, "solve", lambda *args: solve(*args) * (1 + 1e-13))
    monkeypatch.setattr(np, "interp", lambda *args: interpolate(*args) * (1 + 1e-15))
    assert fit(track, max_points=20, speed_m_s="recorded").mission == usual.mission


@pytest.mark.usefixtures("brief_search")
def test_a_given_speed_is_asked_for_once_after_a_second_here() -> None:
    """Then it holds for the whole route, also on a vehicle that would undo the first item of a mission."""
    items = fit(wander(4, fixes=40), max_points=12, speed_m_s=3.0).mission.items
    assert items[:2] == speed_from_the_start(3.0)
    assert [item.command for item in items].count(Command.CHANGE_SPEED) == 1


@pytest.mark.usefixtures("brief_search")
def test_the_vehicles_own_speed_asks_for_none() -> None:
    """Without a speed there is no speed change."""
    assert all(item.is_waypoint for item in fit(wander(4, fixes=40), max_points=12).mission.items)


@pytest.mark.usefixtures("brief_search")
def test_a_long_hover_is_waited_out_in_whole_seconds() -> None:
    """A flight that hovers for half a minute between two legs is there for as long, mostly waiting."""
    out, back = along([(0, 0), (60, 0)], 4.0), along([(60, 0), (60, 60)], 4.0)
    north_east = np.concatenate(
        [out.north_east_m(FRAME), np.tile([60.0, 0.0], (120, 1)), back.north_east_m(FRAME)]
    )
    track = track_through(north_east, np.arange(len(north_east)) / 4.0)
    result = fit(track, max_points=20, speed_m_s="recorded")
    longest = max(item.hold_s for _, item in result.mission.waypoints)
    there = track.lat_deg[len(out) + 60], track.lon_deg[len(out) + 60]
    air = predicted(result)
    near = np.linalg.norm(air.north_east_m - track.frame.to_metres(*there), axis=1) < 1.0
    assert near.sum() * (air.time_s[1] - air.time_s[0]) == pytest.approx(30, abs=3)
    assert 20 <= longest == round(longest)


@pytest.mark.slow
def test_a_flown_mission_is_followed_as_well_as_by_itself() -> None:
    """With a stop of 0.3 m, and a corner that the vehicle cut, where no fix is."""
    corners = [(0.0, 0.0), (0.0, 0.3), (0.0, 40.0), (40.0, 40.0), (40.0, 0.0), (10.0, 0.0)]
    mission = replace(
        draft_of(corners, [False] * 6, [6, 8, 7, 0, 9, 0]),
        speed_m_s=np.array([np.nan, 1.0, 3.0, 4.0, 4.0, 5.0]),
    )
    recording = recording_of(simulate_draft(mission, Limits(), 0.02))
    track = track_through(recording.north_east_m, recording.time_s)
    found = fit(track, altitude_m=20.0, speed_m_s="recorded")
    assert position_error(found).mean < 0.3
    assert path_error(found).max < 0.3
    problem = problem_for(local_track(track, 20.0), 100, Limits(), timed=True)
    assert found.objective_m < problem.exact.evaluate(mission).objective_m


@pytest.mark.usefixtures("brief_search")
def test_stops_are_left_straight_with_high_limits() -> None:
    """A pause of 8 s on a circle: what a spline would do from there cannot be foreseen at 10 m/s²."""
    lap = circle().north_east_m(FRAME)
    north_east = np.concatenate([lap, np.tile(lap[-1], (32, 1)), lap])
    track = track_through(north_east, np.arange(len(north_east)) / 4.0)
    after_stop = {}
    for accel_m_s2 in (2.5, 10.0):
        limits = Limits(wp_accel_m_s2=accel_m_s2, wp_jerk_m_s3=accel_m_s2)
        waypoints = [
            item
            for _, item in fit(track, max_points=14, speed_m_s="recorded", limits=limits).mission.waypoints
        ]
        after_stop[accel_m_s2] = [item.is_spline for before, item in pairwise(waypoints) if before.hold_s > 0]
    assert any(after_stop[2.5])
    assert len(after_stop[10.0]) > 1
    assert not any(after_stop[10.0])


@pytest.mark.usefixtures("brief_search")
def test_recorded_heights_are_flown_but_not_into_the_ground() -> None:
    """Heights as recorded, none below 5 m."""
    track = along([(0, 0), (120, 0)], 3.0)
    rising = replace(track, alt_m=np.linspace(0, 25, len(track)), amsl_m=400 + np.linspace(0, 25, len(track)))
    heights = [item.alt_m for _, item in fit(rising, max_points=10, altitude_m="recorded").mission.waypoints]
    assert min(heights) >= 5.0
    assert heights[-1] == pytest.approx(25, abs=0.5)
    assert heights == sorted(heights)


@pytest.mark.usefixtures("brief_search")
def test_a_flight_may_be_shorter_than_the_way_down_from_the_take_off() -> None:
    """Around a circle of 60 cm at five metres, after a take-off to 60 m."""
    found = fit(circle(0.3, 1.0), altitude_m=5.0, speed_m_s="recorded", takeoff_m=60.0)
    assert found.predicted_duration_s < 15.0


@pytest.mark.usefixtures("brief_search")
def test_figures_of_eight_are_flown_in_order() -> None:
    """Four laps of an eight stay four laps: the path is as long, and no lap is borrowed."""
    track = eights(laps=4)
    result = fit(track, max_points=40)
    assert planned_path(result.mission, track.frame).length_m == pytest.approx(track.length_m, rel=0.1)
    assert planned_error(result).mean < 1.0


@pytest.mark.usefixtures("brief_search")
@pytest.mark.parametrize(
    "track",
    [
        along([(0, 0), (2, 0)], 2.0).select(slice(0, 1)),
        along([(0, 0), (2, 0)], 2.0).select(np.array([0, 4])),
        track_through(np.zeros((2, 2)), np.zeros(2)),
        track_through(np.zeros((9, 2)), np.arange(9.0)),
        hover(),
        along([(0, 0), (200, 0)], 6.0, rate_hz=0.5),
        along([(0, 0), (40, 0)], 4.0, rate_hz=50.0),
    ],
    ids=["one fix", "two fixes", "one instant", "one place", "hover", "0.5 Hz", "50 Hz"],
)
@pytest.mark.parametrize("speed_m_s", ["recorded", None])
def test_any_track_is_fitted(track: Track, speed_m_s: float | None) -> None:
    """However little a track says, the route ends within 1 m of where it ends: there may be an overshoot."""
    result = fit(track, max_points=10, speed_m_s=speed_m_s)
    assert 1 <= len(result.mission.waypoints) <= 10
    assert np.linalg.norm(places_m(result)[-1] - track.north_east_m()[-1]) < 1.0


@pytest.mark.parametrize("max_points", [1, 2, 3])
def test_any_budget_is_kept(max_points: int) -> None:
    """Even one waypoint is a route: to where the recording ended."""
    track = wander(5, fixes=30)
    result = fit(track, max_points=max_points)
    assert len(result.mission.waypoints) <= max_points
    assert np.linalg.norm(places_m(result)[-1] - track.north_east_m()[-1]) < 0.1


def test_a_track_without_fixes_cannot_be_fitted() -> None:
    """No position is an expected failure."""
    with pytest.raises(LogError, match="no position"):
        fit(wander(1).select(slice(0, 0)))


def _blas_threads() -> list[int]:
    """How many threads each of numpy's matrix libraries may use, of those that threadpoolctl knows."""
    return [each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"]


@pytest.mark.usefixtures("brief_search")
def test_matrices_so_small_are_left_to_one_thread() -> None:
    """Others would wait for it, and take as much of the processors' time."""
    if not _blas_threads():
        pytest.skip("threadpoolctl does not know numpy's matrix library, as on Apple's processors")
    threads: list[int] = []

    def progress(done: int, total: int) -> None:
        threads.extend(_blas_threads())

    fit(wander(6, fixes=30), max_points=8, progress=progress)
    assert set(threads) == {1}


@pytest.mark.usefixtures("brief_search")
def test_progress_runs_to_its_total() -> None:
    """What is done grows until it is all that there is."""
    told: list[tuple[int, int]] = []
    fit(wander(6, fixes=30), max_points=8, progress=lambda done, total: told.append((done, total)))
    done = [each for each, _ in told]
    assert done == sorted(done)
    assert told[-1][0] == told[-1][1]


@pytest.mark.usefixtures("brief_search")
@settings(max_examples=3, suppress_health_check=list(HealthCheck))
@given(st.integers(0, 10_000), st.integers(4, 25), st.sampled_from(["recorded", None]))
def test_what_every_fit_keeps(seed: int, max_points: int, speed_m_s: str | None) -> None:
    """Budget, ends, surroundings and legs are kept, and no classic route is better by the same measure."""
    track = wander(seed, fixes=50)
    result = fit(track, max_points=max_points, speed_m_s=speed_m_s)  # type: ignore[arg-type]
    places, line = places_m(result), track.north_east_m()
    assert len(places) <= max_points
    assert np.linalg.norm(places[0] - line[0]) < 0.1
    assert np.linalg.norm(places[-1] - line[-1]) < 1.01
    assert (distance_to_line_m(places, line) <= 5.0).all()
    assert all(np.isfinite([item.lat_deg, item.lon_deg, item.alt_m]).all() for item in result.mission.items)
    assert all(item.hold_s == round(item.hold_s) for _, item in result.mission.waypoints)
    speeds = [item.params[1] for item in result.mission.items if not item.is_waypoint]
    assert all(0.2 <= speed <= 30 for speed in speeds)
    assert (
        result.objective_m <= min(rival_objectives_m(track, max_points, timed=speed_m_s is not None)) + 1e-9
    )


@pytest.mark.slow
def test_the_sample_flight_is_followed_in_space_and_in_time() -> None:
    """The packaged flight, 635 s: within 0.6 m in space and 4 m in time on average, as predicted."""
    result = fit(read_log(SAMPLE).track, speed_m_s="recorded")
    assert path_error(result).mean <= 0.6
    assert position_error(result).mean <= 4.0


@pytest.mark.slow
def test_a_vehicle_that_cannot_keep_up_stays_on_its_path() -> None:
    """A slalom at 9 m/s, flown at a third of that; it is not cut short, nor cut down, to be less late."""
    north_m = np.linspace(0.0, 80.0, 80)
    slalom = np.column_stack([north_m, 10 * np.sin(north_m * 2 * np.pi / 40)])
    result = fit(along(slalom.tolist(), 9.0), max_points=11, speed_m_s="recorded")
    assert path_error(result).max <= 0.8
    assert position_error(result).max > 20.0


@pytest.mark.slow
def test_dronekits_flights_are_followed() -> None:
    """Seven flights joined stay within 0.40, 0.90 and 1.8 m as planned; flight 2 within 6 m in time."""
    track = read_log(other_log("dronekit-flight.tlog")).track
    joined = fit(track)
    planned = planned_error(joined)
    assert planned.mean <= 0.40
    assert planned.p95 <= 0.90
    assert planned.max <= 1.8
    second = fit(select(track, 2), speed_m_s="recorded")
    assert path_error(second).mean <= 0.4
    assert position_error(second).mean <= 6.0
    assert second.predicted_duration_s == pytest.approx(142, rel=0.05)
