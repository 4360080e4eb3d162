"""References: in step with the recording, within what the vehicle can do."""

from __future__ import annotations

import numpy as np
import pytest

from flight_replay.exceptions import MissionError
from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.geometry.reference_motion import ReferenceMotion
from flight_replay.planning.drag import sitl_drag
from flight_replay.planning.following.reference_planner import RecordedMotion, ReferenceBounds, plan_reference
from flight_replay.planning.following.samples import filled, times_with_bridges
from flight_replay.simulator.dynamics.limits import Limits

BOUNDS = ReferenceBounds.of(Limits())
DRAG = sitl_drag(400.0)


def _plan(
    times_s: np.ndarray, places_m: np.ndarray, headings_deg: np.ndarray | None = None
) -> ReferenceMotion:
    headings = np.full(len(times_s), np.nan) if headings_deg is None else headings_deg
    recorded = RecordedMotion(FlatFrame(47.0, 8.0), times_s, places_m, headings)
    return plan_reference(recorded, BOUNDS, DRAG, headings=True, floor_m=5.0)


def test_a_flight_within_the_limits_is_followed_to_centimetres() -> None:
    times_s = np.arange(0.0, 60.0, 0.25)
    angle = 0.25 * times_s
    places = np.column_stack([15 * np.sin(angle), 15 - 15 * np.cos(angle), 20 + 5 * np.sin(0.2 * times_s)])
    reference = _plan(times_s, places, np.degrees(angle) % 360)
    assert np.abs(reference.positions_m(times_s) - places).max() < 0.05
    headings = reference.headings_deg(times_s)
    assert headings is not None
    assert np.abs((headings[0] - np.degrees(angle) + 180) % 360 - 180).max() < 1.0
    assert reference.begin_s < 0.0 < times_s[-1] < reference.end_s


def test_a_flight_beyond_the_limits_stays_within_them() -> None:
    times_s = np.arange(0.0, 40.0, 0.2)
    heights = 20 + 10 * np.sin(times_s)
    places = np.column_stack([40 * np.sin(0.8 * times_s), np.zeros(len(times_s)), heights])
    reference = _plan(times_s, places, 200 * times_s % 360)
    fine_s = np.linspace(reference.begin_s, reference.end_s, 4000)
    velocity, acceleration = reference.velocities_m_s(fine_s), reference.accelerations_m_s2(fine_s)
    thrust = acceleration[:, :2] + DRAG.acceleration_m_s2(velocity[:, :2])
    assert np.hypot(*thrust.T).max() < BOUNDS.thrust.along_m_s2 + 0.1
    assert velocity[:, 2].max() < 1.04 * BOUNDS.up_m_s
    assert -velocity[:, 2].min() < 1.04 * BOUNDS.down_m_s
    rates = reference.headings_deg(fine_s)
    assert rates is not None
    assert np.abs(rates[1]).max() < 1.04 * BOUNDS.turn_deg_s


def test_without_limits_a_turn_takes_a_second() -> None:
    """ATC_SLEW_YAW and ATC_ACCEL_Y_MAX of 0 are none."""
    bounds = ReferenceBounds.of(Limits(yaw_slew_rad_s=0.0, yaw_accel_rad_s2=0.0))
    assert (bounds.turn_deg_s, bounds.turn_deg_s2) == pytest.approx((0.98 * 360.0, 0.5 * 720.0))


def test_turns_leave_more_of_the_lean_than_speeding_up() -> None:
    times_s = np.arange(0.0, 40.0, 0.2)
    turn, height = 1.1 * times_s, np.full(len(times_s), 20.0)
    there_and_back = np.column_stack([40 * np.sin(0.8 * times_s), np.zeros(len(times_s)), height])
    round_and_round = np.column_stack([6 * np.sin(turn), 6 * np.cos(turn), height])
    most = []
    for places in (there_and_back, round_and_round):
        reference = _plan(times_s, places)
        fine_s = np.linspace(5.0, 35.0, 3000)
        velocity = reference.velocities_m_s(fine_s)[:, :2]
        thrust = reference.accelerations_m_s2(fine_s)[:, :2] + DRAG.acceleration_m_s2(velocity)
        most.append(np.hypot(*thrust.T).max())
    assert most[0] == pytest.approx(BOUNDS.thrust.along_m_s2, abs=0.1)
    assert most[1] < BOUNDS.thrust.across_m_s2 + 0.15


def test_it_is_at_speed_when_the_recording_begins() -> None:
    times_s = np.arange(0.0, 10.0, 0.2)
    places = np.column_stack([5.0 * times_s, np.zeros(len(times_s)), np.full(len(times_s), 30.0)])
    reference = _plan(times_s, places)
    assert reference.state(0.0).velocity_m_s[0] == pytest.approx(5.0, abs=0.3)
    assert np.abs(reference.state(reference.begin_s).velocity_m_s).max() < 1e-6
    assert reference.heading is None


def test_without_a_heading_in_the_log_the_vehicle_turns_as_it_wants() -> None:
    times_s = np.arange(0.0, 10.0, 0.2)
    places = np.column_stack([times_s, times_s, np.full(len(times_s), 30.0)])
    assert _plan(times_s, places).heading_deg(3.0) is None


def test_a_gap_in_the_log_is_flown_straight() -> None:
    times_s = np.concatenate([np.arange(0.0, 10.0, 0.2), np.arange(25.0, 35.0, 0.2)])
    north = np.where(times_s < 10, times_s, times_s)
    places = np.column_stack([north, np.zeros(len(times_s)), np.full(len(times_s), 30.0)])
    between = _plan(times_s, places).positions_m(np.linspace(10.0, 25.0, 100))
    assert np.abs(between[:, 1]).max() < 0.01
    assert np.diff(between[:, 0]).min() > -0.01


def test_a_single_fix_cannot_be_followed() -> None:
    with pytest.raises(MissionError, match="longer part"):
        _plan(np.zeros(1), np.zeros((1, 3)))


def test_jumps_take_the_time_that_they_need() -> None:
    times_s = np.array([0.0, 1.0, 2.0, 2.4, 3.4])
    places = np.array([[0.0, 0], [1, 0], [2, 0], [102, 0], [103, 0]])
    later_s, bridges = times_with_bridges(times_s, places, 10.0)
    assert later_s == pytest.approx([0.0, 1.0, 2.0, 17.0, 18.0])
    assert [(bridge.time_s, bridge.distance_m) for bridge in bridges] == [(2.0, 100.0)]


@pytest.mark.parametrize("pace", [0.1, 0.5, 1.0, 2.0])
def test_a_jump_is_one_at_any_pace(pace: float) -> None:
    """Over a glitch of 30 m a vehicle that follows slowly would rush, and come late."""
    recorded_s = 50.0 + np.arange(0.0, 10.0, 0.2)
    along_m = 2.0 * (recorded_s - 50.0) + np.where(recorded_s > 55.0, 30.0, 0.0)
    places_m = np.column_stack([along_m, 0.0 * along_m])
    times_s, bridges = times_with_bridges(recorded_s, places_m, 10.0, pace)
    assert [bridge.distance_m for bridge in bridges] == pytest.approx([30.4])
    assert times_s[0] == 0.0
    assert times_s[-1] == pytest.approx(9.6 / pace + 5.0 + 3.04)


@pytest.mark.parametrize("jump_m", [0.0, 200.0])
def test_a_fast_flight_does_not_jump(jump_m: float) -> None:
    """At 30 m/s, braking at the end; a jump in it is still one."""
    times_s = np.arange(0.0, 60.0, 0.5)
    along_m = np.cumsum(15.0 * np.clip((60.0 - times_s) / 10.0, 0.0, 1.0))
    along_m[40:] += jump_m
    _, bridges = times_with_bridges(times_s, np.column_stack([along_m, 0.0 * along_m]), 10.0)
    assert [bridge.time_s for bridge in bridges] == ([19.5] if jump_m else [])


@pytest.mark.parametrize(("fixes", "jumps"), [(1, 0), (2, 1)])
def test_a_single_fast_step_is_a_jump(fixes: int, jumps: int) -> None:
    """Nothing around it is as fast."""
    places_m = np.array([[0.0, 0.0], [100.0, 0.0]])[:fixes]
    assert len(times_with_bridges(np.arange(float(fixes)), places_m, 10.0)[1]) == jumps


def test_fixes_weigh_by_their_share_of_time() -> None:
    times_s, _, weights = filled(np.array([0.0, 0.5, 1.5, 6.0]), np.zeros((4, 1)))
    assert weights[:4] == pytest.approx([0.5, 0.75, 1.5, 2.0])
    assert len(times_s) > 4
    assert weights[4:].max() < 0.1
