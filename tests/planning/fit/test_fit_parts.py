"""The parts of the fit: weights, residuals, pace, reducers, the flown part, limits."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.geometry.arrays import Floats
from flight_replay.logs.track import Armed, Track
from flight_replay.planning.altitude import MIN_ALTITUDE_M, plausible_altitudes_m
from flight_replay.planning.fit.basis import weights
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.gauss_newton import Residuals, gauss_newton_step
from flight_replay.planning.fit.knot_placement import first_draft, waypoints_needed
from flight_replay.planning.fit.line_simplification import douglas_peucker, straight_draft
from flight_replay.planning.fit.objective import evaluate, match_to_plan
from flight_replay.planning.fit.reference import LocalTrack, hovers, local_track
from flight_replay.planning.fit.result import lag_notes
from flight_replay.planning.fit.simulated_draft import simulate_draft
from flight_replay.planning.fit.speed_schedule import best_lateness_s
from flight_replay.planning.flown_part import flown_part
from flight_replay.planning.required_limits import required_limits
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import FRAME, along, circle, hover, track_through, wander


def draft_of(places: list[tuple[float, float]], spline: list[bool], hold: list[float]) -> Draft:
    flat = np.column_stack([np.array(places, float), np.full(len(places), 20.0)])
    return Draft(flat, np.array(spline), np.array(hold), np.full(len(places), np.nan))


MIXED = draft_of(
    [(0, 0), (10, 2), (18, 10), (30, 8), (31, 20), (45, 22)],
    [False, True, True, False, True, True],
    [1, 0, 0, 0, 2, 0],
)


def joined(*parts: Track) -> Track:
    columns = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in Track.__dataclass_fields__
    }
    return Track(**columns)


def test_the_weights_draw_the_planned_path() -> None:
    """Every point of a mixed path is the weighted sum of its places, straight legs, curves and halts."""
    path = MIXED.path(0.01)
    for leg in range(1, len(MIXED)):
        points = path.north_east_m[path.seq == leg]
        part = np.arange(1, len(points) + 1) / len(points)
        drawn = weights(MIXED, np.full(len(points), leg), part) @ MIXED.places_m[:, :2]
        assert np.allclose(drawn, points, atol=1e-9)


def test_a_pull_moves_the_path_to_where_it_draws() -> None:
    """Points drawn aside by a metre arrive there, and the ends stay."""
    draft = draft_of([(10.0 * i, 0) for i in range(8)], [i > 0 for i in range(8)], [1.0] + [0.0] * 7)
    leg, part = np.repeat(np.arange(2, 7), 3), np.tile([0.2, 0.5, 0.9], 5)
    off = np.tile([0.0, 1.0], (15, 1))
    residual = Residuals(leg, part, np.tile([1.0, 0.0], (15, 1)), off, np.ones(15))
    moved = gauss_newton_step(draft, [residual], smoothing=1e-4)
    there = weights(moved, leg, part) @ moved.places_m[:, :2]
    assert np.allclose(there[6:9, 1], 1.0, atol=0.05)
    assert np.allclose(moved.places_m[[0, -1]], draft.places_m[[0, -1]])


def test_two_places_cannot_be_pulled() -> None:
    """A route of two places is its ends."""
    draft = draft_of([(0, 0), (10, 0)], [False, False], [1, 0])
    assert gauss_newton_step(draft, [], smoothing=1.0) is draft


def test_lateness_is_spread_where_it_costs_least() -> None:
    """A stretch that takes 2 s too long is entered early and left late, not late all the way after."""
    wanted = np.array([0.0, 4, 4, 2, 4, 4])
    least = np.array([0.0, 2, 2, 4, 2, 2])
    late = best_lateness_s(wanted, least, np.ones(6))
    assert (np.diff(late) >= least[1:] - wanted[1:] - 1e-9).all()
    assert np.abs(late).sum() == pytest.approx(2.0)


def test_no_lateness_where_the_vehicle_keeps_up() -> None:
    """Legs that can be flown in time are."""
    assert np.allclose(best_lateness_s(np.full(5, 3.0), np.full(5, 2.0), np.ones(5)), 0.0)


def test_lateness_that_cannot_be_made_good_stays() -> None:
    """A route that is too fast from end to end is ever later."""
    late = best_lateness_s(np.full(4, 1.0), np.full(4, 3.0), np.ones(4))
    assert late.tolist() == [0, 2, 4, 6]


def test_douglas_peucker_keeps_corners() -> None:
    """A line around three corners keeps them and its ends, and no more than asked."""
    line = along([(0, 0), (40, 0), (70, 40), (10, 120)], 2.0).north_east_m(FRAME)
    kept = douglas_peucker(line, 10)
    assert kept.tolist() == [0, 80, 180, 380]
    assert len(douglas_peucker(line, 3)) == 3


def test_hovers_are_found_where_the_vehicle_stood() -> None:
    """Half a minute in the air is one hover; a flight without any has none."""
    found = hovers(local_track(hover(), 20.0), 5)
    assert len(found) == 1
    assert found[0].seconds == pytest.approx(29.75)
    assert hovers(local_track(wander(1), 20.0), 5) == []


def test_the_flown_part_leaves_out_the_ground_and_closes_the_gap() -> None:
    """Two armed stretches are joined without the minutes between, which is said."""
    first = along([(0, 0), (30, 0)], 3.0)
    ground = replace(hover(60.0), armed=np.zeros(240, np.int8))
    second = along([(30, 0), (60, 0)], 3.0)
    apart = [
        replace(part, time_s=part.time_s + begin)
        for part, begin in ((first, 0.0), (ground, 11.0), (second, 300.0))
    ]
    part, notes = flown_part(joined(*apart))
    assert len(part) == len(first) + len(second)
    assert part.time_s[-1] == pytest.approx(20.25)
    assert notes == (f"240 of {240 + len(part)} fixes are left out: they are not part of a flight.",)


def test_a_far_join_is_said() -> None:
    """A second flight that begins 100 m away is joined by a way that nobody flew, and that is said."""
    first = along([(0, 0), (30, 0)], 3.0)
    second = along([(130, 0), (160, 0)], 3.0)
    between = replace(first.select(slice(0, 1)), time_s=np.array([20.0]), armed=np.array([Armed.NO], np.int8))
    _, notes = flown_part(joined(first, between, replace(second, time_s=second.time_s + 60)))
    assert any("Flight 2 begins 100 m" in note for note in notes)


def test_a_log_without_flights_is_taken_whole() -> None:
    """Where nothing tells flying from standing, all fixes count."""
    track = replace(hover(5.0), armed=np.zeros(20, np.int8))
    part, notes = flown_part(track)
    assert len(part) == len(track)
    assert len(notes) == 1


def test_heights_before_home_was_set_are_not_believed() -> None:
    """Heights of 580 m that come from home not being set yet are replaced by the first believable one."""
    track = along([(0, 0), (30, 0)], 3.0)
    heights = np.full(len(track), 12.0)
    heights[:5] = 412.0
    heights[-1] = -1.0
    strange = replace(track, alt_m=heights, amsl_m=np.full(len(track), 412.0))
    assert plausible_altitudes_m(strange)[:6].tolist() == [12.0] * 6
    strange = replace(track, alt_m=np.full(len(track), np.nan))
    assert (plausible_altitudes_m(strange) == MIN_ALTITUDE_M).all()


def test_a_choice_of_speeds_is_flown_and_kept() -> None:
    """Speeds chosen as legs begin become the draft's, and fly alike when they are set beforehand."""
    draft = draft_of([(0, 0), (30, 0), (60, 10), (90, 0)], [False, True, True, True], [1, 0, 0, 0])
    asked: list[int] = []

    def choose(place: int, now_s: float) -> float:
        asked.append(place)
        return 2.0 if place < 3 else 4.0

    chosen = simulate_draft(draft, Limits(), 0.05, choose)
    assert sorted(set(asked)) == [1, 2, 3]
    assert chosen.draft.speed_m_s[[1, 3]].tolist() == [2.0, 4.0]
    assert np.isnan(chosen.draft.speed_m_s[[0, 2]]).all()
    again = simulate_draft(chosen.draft, Limits(), 0.05)
    assert np.allclose(again.passed_s, chosen.passed_s)


def test_the_objective_counts_space_plan_and_time() -> None:
    """A flight beside the recording and slower than it costs more in each of its parts."""
    recording = local_track(along([(0, 0), (60, 0)], 4.0), 20.0)
    line = straight_draft(recording, np.array([0, len(recording) - 1]))
    aside = replace(line, places_m=line.places_m + np.array([0.0, 2.0, 0.0]))
    slow = replace(line, speed_m_s=np.array([np.nan, 1.0]))
    good, beside, late = (
        evaluate(simulate_draft(draft, Limits(), 0.05), recording, timed=True)
        for draft in (line, aside, slow)
    )
    assert beside.objective_m > good.objective_m + 2.0
    assert late.objective_m > good.objective_m + 0.5
    early = evaluate(good.flown, replace(recording, time_s=recording.time_s * 3), timed=False)
    assert early.late_m[8:].max() == 0


def test_a_first_draft_stands_closer_where_it_curves() -> None:
    """More than half of the places go to the curved half of a way."""
    straight = np.column_stack([np.linspace(-120, 0, 100), np.zeros(100)])
    turn = np.linspace(0, 6 * np.pi, 100)
    loops = np.column_stack([6.4 * np.sin(turn), 6.4 * (1 - np.cos(turn))])
    line = np.concatenate([straight, loops])
    recording = LocalTrack(np.arange(200.0) / 3, line, np.full(200, 20.0))
    draft = first_draft(recording, 30, [], timed=False)
    assert (draft.places_m[:, 0] > -7).sum() > 16


def test_enough_places_are_fewer_for_simple_ways() -> None:
    """A straight line needs two places, a circle some, a hand-flown way most."""
    counts = [
        waypoints_needed(local_track(track, 20.0), 40, [], timed=False)
        for track in (along([(0, 0), (100, 0)], 5.0), circle(), wander(2, fixes=200))
    ]
    assert counts[0] == 2
    assert 4 < counts[1] < 30
    assert counts[2] == 40


def test_on_plan_finds_fixes_on_their_legs() -> None:
    """Fixes on the planned path have no distance and lie on the leg that they were taken from."""
    path = MIXED.path(0.001)
    keep = np.arange(0, len(path.seq), 9)
    recording = LocalTrack(keep.astype(float), path.north_east_m[keep], np.zeros(len(keep)))
    leg, _, off, direction = match_to_plan(MIXED, recording)
    assert np.abs(off).max() < 0.05
    assert (np.abs(leg - path.seq[keep]) <= 1).all()
    assert np.allclose(np.linalg.norm(direction[3:], axis=1), 1.0)


def sped_up(track: Track, factor: float) -> Track:
    return replace(track, time_s=track.time_s / factor)


def test_limits_are_raised_to_the_recording_and_never_lowered() -> None:
    """A circle flown at 4.5 m/s² needs twice that and more; a slow one needs nothing."""
    fast = required_limits(sped_up(circle(20.0, 3.0, laps=2), 3.16), Limits())
    assert 9.0 < fast["wp_accel_m_s2"] < 13.0
    assert fast["wp_jerk_m_s3"] == fast["wp_accel_m_s2"]
    assert Limits().lean_angle_rad < fast["lean_angle_rad"] < np.pi / 4 + 1e-9
    assert "wp_accel_m_s2" not in required_limits(circle(20.0, 3.0), Limits())
    assert "wp_speed_m_s" in required_limits(along([(0, 0), (400, 0)], 15.0), Limits())


def test_limits_use_recorded_velocities_where_there_are_some() -> None:
    """Climb rates come from the log's own velocities; a track of one fix raises nothing."""
    track = along([(0, 0), (60, 0)], 3.0)
    rate: Floats = np.full(len(track), 4.0)
    climbing = replace(track, up_m_s=rate, north_m_s=rate, east_m_s=0 * rate)
    assert required_limits(climbing, Limits())["wp_speed_up_m_s"] == pytest.approx(4.8)
    assert required_limits(track.select(slice(0, 1)), Limits()) == {}


def test_the_nearest_place_of_a_recording() -> None:
    """A place beside the line through two fixes is nearest to the line, not to a fix."""
    recording = local_track(track_through(np.array([[0.0, 0], [10, 0]]), np.array([0.0, 5])), 20.0)
    assert np.allclose(recording.nearest_m(np.array([[4.0, 3.0]])), [[4.0, 0.0]], atol=1e-6)


def test_where_the_vehicle_lags_is_said() -> None:
    """A recording flown twice as fast as the vehicle can is behind from somewhere on; a slow one nowhere."""
    fast = local_track(sped_up(wander(3), 2.0), 20.0)
    slow = local_track(along([(0, 0), (60, 0)], 0.5), 20.0)
    lags = []
    for recording in (fast, slow):
        line = straight_draft(recording, douglas_peucker(recording.north_east_m, 12))
        best = evaluate(simulate_draft(line, Limits(), 0.05), recording, timed=True)
        lags.append(lag_notes(best, recording))
    assert len(lags[0]) == 1
    assert "behind by up to" in lags[0][0]
    assert lags[1] == ()
