"""The objective of the fit, and where planned paths have the fixes."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.planning.fit.first_drafts.line_simplification import straight_draft
from flight_replay.planning.fit.lateness import position_offsets_m
from flight_replay.planning.fit.objective import (
    PATH_SHARES,
    TIMED_PATH_SHARES,
    Evaluation,
    evaluate,
    objective_lower_bound_m,
    seconds_cost_m_s,
)
from flight_replay.planning.fit.offsets import Offsets, directions, match_to_plan
from flight_replay.planning.fit.reference import LocalTrack, local_track
from flight_replay.planning.fit.simulated_draft import SimulatedDraft, simulate_draft
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import MIXED, along


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
    early = evaluate(good.flight, replace(recording, time_s=recording.time_s * 3), timed=False)
    assert early.late_m[8:].max() == 0


@pytest.mark.parametrize("speed_m_s", [1.0, 30.0])
def test_what_a_second_costs_is_what_the_objective_grows_by(speed_m_s: float) -> None:
    """A vehicle slower than the recorded one is farther off everywhere for it, a faster one nowhere."""
    recording = local_track(along([(0, 0), (60, 0)], 4.0), 20.0)
    line = straight_draft(recording, np.array([0, len(recording) - 1]))
    line = replace(line, speed_m_s=np.array([speed_m_s, np.nan]))
    flight = simulate_draft(line, Limits(wp_speed_m_s=30.0, wp_accel_m_s2=9.0), 0.05)
    usual = evaluate(flight, recording, timed=False)
    later = evaluate(replace(flight, time_s=flight.time_s + 0.1), recording, timed=False)
    a_second_m_s = seconds_cost_m_s(usual, recording)
    assert (usual.late_m[-1] > 0) == (speed_m_s < 4)
    assert 10 * (later.objective_m - usual.objective_m) == pytest.approx(a_second_m_s[0], rel=0.15, abs=0.01)
    assert np.diff(a_second_m_s).max() <= 0


def evaluation_with(planned_m: list[float], flown_m: list[float], late_m: list[float]) -> Evaluation:
    """Fixes so far beside the planned path, beside the flown one, and from where the vehicle is."""
    n = len(planned_m)
    recording = local_track(along([(0, 0), (n - 1, 0)], 1.0, rate_hz=1.0), 20.0)
    line = straight_draft(recording, np.array([0, n - 1]))
    whole = evaluate(simulate_draft(line, Limits(), 0.05), recording, timed=True)
    planned, flown = (
        (Offsets(np.zeros(n, np.intp), np.zeros(n), np.column_stack([np.zeros(n), off])),) * 2
        for off in (planned_m, flown_m)
    )
    return replace(whole, planned=planned, flown=flown, late_off_m=np.array(late_m)[:, None])


def test_the_objective_is_a_sum_with_fixed_shares() -> None:
    """Where the speed is kept the flown path error whole, 0.3 of the planned one, 0.25 of position error."""
    assert evaluation_with([0, 0, 0], [2, 2, 2], [0, 0, 0]).objective_m == pytest.approx(2.0)
    assert evaluation_with([1, 1, 1], [0, 0, 0], [0, 0, 0]).objective_m == pytest.approx(TIMED_PATH_SHARES[1])
    assert evaluation_with([0, 0, 0], [0, 0, 0], [2, 4, 6]).objective_m == pytest.approx(1.0)
    assert evaluation_with([1, 1, 1], [2, 2, 2], [2, 4, 6]).objective_m == pytest.approx(
        3.0 + TIMED_PATH_SHARES[1]
    )


def test_one_fix_at_2_m_counts_as_sixteen_at_1_m() -> None:
    """Path errors are power means with exponent 4."""
    zeros = [0.0] * 32
    far = evaluation_with([2.0, *zeros[1:]], zeros, zeros)
    many = evaluation_with([1.0] * 16 + zeros[16:], zeros, zeros)
    assert far.objective_m == pytest.approx(many.objective_m)
    assert far.objective_m == pytest.approx(TIMED_PATH_SHARES[1] * 0.5**0.25)


def test_at_the_vehicles_own_speed_the_worse_of_the_paths_counts_most() -> None:
    """Alike, they count their shares of two; three and one metres are worse than twice about two."""

    def cost_m(planned_m: float, flown_m: float) -> float:
        whole = evaluation_with([planned_m] * 3, [flown_m] * 3, [0, 0, 0])
        return replace(whole, timed=False).objective_m

    assert cost_m(2.0, 2.0) == pytest.approx(4.0)
    flown, planned = PATH_SHARES
    by_flown, by_planned = ((cost_m(*errors) - 4.0) / 0.001 for errors in ((2.0, 2.001), (2.001, 2.0)))
    assert (by_flown, by_planned) == pytest.approx((flown, planned), rel=0.01)
    assert cost_m(1.0, 3.0) > cost_m(2.0, 2.2)


def test_the_planned_path_alone_bounds_the_objective_from_below() -> None:
    """A draft 3 m beside the recording costs at least as much, however it is flown."""
    recording = local_track(along([(0, 0), (60, 0)], 4.0), 20.0)
    line = straight_draft(recording, np.array([0, len(recording) - 1]))
    aside = replace(line, places_m=line.places_m + np.array([0.0, 3.0, 0.0]))
    assert objective_lower_bound_m(aside, recording) == pytest.approx(6 * (PATH_SHARES[1] / 2) ** 0.25)
    flight = simulate_draft(aside, Limits(), 0.05)
    assert evaluate(flight, recording, timed=False).objective_m > objective_lower_bound_m(aside, recording)


def test_fixes_are_matched_to_their_legs() -> None:
    """Fixes on the planned path have no distance and lie on the leg that they were taken from."""
    path = MIXED.path(0.001)
    keep = np.arange(0, len(path.seq), 9)
    recording = LocalTrack(keep.astype(float), path.north_east_m[keep], np.zeros(len(keep)))
    there, back = match_to_plan(MIXED, recording)
    assert there.apart_m.max() < 0.05
    assert (np.abs(there.leg - path.seq[keep]) <= 1).all()
    assert np.allclose(np.linalg.norm(directions(MIXED, there)[3:], axis=1), 1.0)
    assert back.apart_m.max() < 0.5


def test_a_climb_on_the_spot_is_matched_by_height() -> None:
    """Over one place, fixes belong to the leg that is at their height; half way up is half of the leg."""
    up_m = np.concatenate([np.full(5, 10.0), np.linspace(10.0, 30.0, 21), np.full(5, 30.0)])
    recording = LocalTrack(np.arange(31.0), np.zeros((31, 2)), up_m)
    draft = straight_draft(recording, np.array([0, 4, 25, 30]))
    there, _ = match_to_plan(draft, recording)
    assert there.leg[15] == 2
    assert there.part[15] == pytest.approx(0.5, abs=0.01)
    assert there.apart_m.max() == 0.0


def test_being_at_another_height_at_a_time_counts() -> None:
    """A vehicle that stays below while the recorded one climbs is as far off as it is below."""
    recording = LocalTrack(np.arange(3.0), np.zeros((3, 2)), np.array([10.0, 12.0, 10.0]))
    low = SimulatedDraft(
        straight_draft(recording, np.array([0, 2])),
        np.arange(3.0),
        np.full((3, 3), [0.0, 0.0, 10.0]),
        np.zeros(2),
    )
    assert position_offsets_m(low, recording).tolist() == [[0, 0, 0], [0, 0, -2], [0, 0, 0]]
    assert evaluate(low, recording, timed=True).late_m.tolist() == [0.0, 2.0, 0.0]


def test_an_overshoot_counts_though_no_fix_is_far_from_the_path() -> None:
    """A path 6 m beyond a turning point passes by all fixes, but not all of it is near them."""
    out = [*range(0, 31), *range(29, -1, -1)]
    recording = LocalTrack(
        np.arange(61.0), np.column_stack([np.array(out, float), np.zeros(61)]), np.full(61, 20.0)
    )
    places = np.array([[0.0, 0, 20], [36, 0, 20], [0, 0, 20]])
    draft = replace(straight_draft(recording, np.array([0, 30, 60])), places_m=places)
    there, back = match_to_plan(draft, recording)
    assert there.apart_m.max() < 0.6
    assert back.apart_m.max() == pytest.approx(6.0, abs=0.1)


def test_a_vehicle_that_is_late_by_whole_turns_is_still_on_its_path() -> None:
    """How far it is from a fix at its time does not tell how far behind it is."""
    turns = [(15 * np.sin(a), 12 * np.sin(2 * a)) for a in np.linspace(0, 8 * np.pi, 120)]
    recording = local_track(along(turns, 6.0), 20.0)
    draft = straight_draft(recording, np.append(np.arange(0, len(recording) - 1, 4), len(recording) - 1))
    slow = replace(draft, speed_m_s=np.full(len(draft), 2.0))
    late = evaluate(simulate_draft(slow, Limits(), 0.05), recording, timed=True)
    assert late.late_m.max() > 25
    assert late.flown[0].apart_m.max() < 2.5
    assert late.flown[1].apart_m.max() < 2.5
