"""The copter takes off, holds, goes, returns and lands as ArduCopter's modes do."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import cos, degrees, hypot, pi, sin

import pytest

from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.flight.copter import STEP_S, Copter
from flight_replay.simulator.flight.guided import GuidedTarget

LIMITS = Limits()


def fly(copter: Copter, done: Callable[[], bool], limit_s: float = 600.0) -> list[Vector]:
    """Step until done; returns where the copter was at each step."""
    places = []
    end = copter.time_s + limit_s
    while not done():
        copter.step()
        places.append(copter.position_m)
        assert copter.time_s < end, "it takes too long"
    return places


def hover(up: float = 20.0, **start: object) -> Copter:
    return Copter(LIMITS, position_m=(0.0, 0.0, up), **start)  # type: ignore[arg-type]


def off(copter: Copter, item_at: Vector) -> float:
    n, e, u = copter.position_m
    return hypot(n - item_at[0], e - item_at[1], u - item_at[2])


def test_it_starts_on_the_ground_and_stays_until_told() -> None:
    """Without a command nothing moves but time."""
    copter = Copter(LIMITS)
    fly(copter, lambda: copter.time_s >= 2.0)
    assert copter.position_m == (0.0, 0.0, 0.0)
    assert copter.landed
    assert not copter.motors
    assert copter.time_s == pytest.approx(2.0)


def test_take_off_waits_runs_up_and_climbs_at_the_climb_speed() -> None:
    """2 s after arming, 0.5 s of spooling and about 0.8 s of throttle, then 2.5 m/s to the altitude."""
    copter = Copter(LIMITS)
    copter.takeoff(20.0)
    assert copter.motors
    fly(copter, lambda: copter.velocity_m_s[2] > 0)
    assert copter.time_s == pytest.approx(2.0 + 0.5 + 2.0 * 0.39, abs=0.15)
    fly(copter, lambda: copter.position_m[2] > 8.0)
    assert copter.velocity_m_s[2] == pytest.approx(2.5, abs=0.1)
    fly(copter, lambda: copter.submode.done)
    fly(copter, lambda: copter.time_s >= 25.0)
    assert copter.position_m == pytest.approx((0.0, 0.0, 20.0), abs=0.05)
    assert not copter.landed


def test_arming_before_shortens_the_wait() -> None:
    """What has passed since arming does not count again."""
    early, late = Copter(LIMITS), Copter(LIMITS)
    early.arm()
    fly(early, lambda: early.time_s >= 2.0)
    for copter in (early, late):
        copter.takeoff(10.0)
        fly(copter, lambda c=copter: c.position_m[2] > 1.0)  # type: ignore[misc]
    assert early.time_s == pytest.approx(late.time_s, abs=2 * STEP_S)


def test_the_same_commands_give_the_same_flight() -> None:
    """Two copters agree to the last bit."""
    one, other = Copter(LIMITS), Copter(LIMITS)
    for copter in (one, other):
        copter.takeoff(12.0)
    assert fly(one, lambda: one.time_s > 15.0) == fly(other, lambda: other.time_s > 15.0)


def test_it_goes_to_a_place_and_rests_there() -> None:
    """GUIDED flies straight, within the waypoint speed, and stops at the position."""
    copter, item_at = hover(), (60.0, -40.0, 30.0)
    copter.follow(GuidedTarget(position_m=item_at))
    places = fly(copter, lambda: copter.submode.done and off(copter, item_at) < 0.05)
    assert max(abs(n * 40 + e * 60) for n, e, _ in places) / hypot(40, 60) < 0.3
    fly(copter, lambda: copter.time_s > 60.0)
    assert off(copter, item_at) < 0.02


def test_holding_stops_within_the_stopping_distance() -> None:
    """From 5 m/s it comes to rest ahead, at the altitude it had."""
    copter = Copter(LIMITS, position_m=(0.0, 0.0, 20.0), velocity_m_s=(5.0, 0.0, 0.0))
    copter.hold()
    fly(copter, lambda: copter.time_s > 20.0)
    assert hypot(*copter.velocity_m_s) < 0.02
    assert 2.0 < copter.position_m[0] < 20.0
    assert copter.position_m[2] == pytest.approx(20.0, abs=0.1)


def test_landing_slows_down_below_ten_metres_and_disarms() -> None:
    """LAND_SPEED holds below LAND_ALT_LOW, and the motors stop 1.5 s after the throttle is closed."""
    copter = hover(25.0)
    copter.land()
    fly(copter, lambda: copter.position_m[2] < 15.0)
    assert copter.velocity_m_s[2] == pytest.approx(-1.5, abs=0.1)
    fly(copter, lambda: copter.position_m[2] < 8.0)
    assert copter.velocity_m_s[2] == pytest.approx(-0.5, abs=0.05)
    fly(copter, lambda: copter.landed)
    down_s = copter.time_s
    fly(copter, lambda: not copter.motors)
    assert copter.time_s - down_s == pytest.approx(2.1, abs=0.3)
    assert copter.position_m == pytest.approx((0.0, 0.0, 0.0), abs=0.1)


def test_return_climbs_waits_and_lands_at_home() -> None:
    """From low and far away: up to RTL_ALT, home, RTL_LOIT_TIME above it, down, motors off."""
    copter = Copter(LIMITS, position_m=(80.0, 50.0, 8.0))
    copter.return_home()
    fly(copter, lambda: hypot(*copter.position_m[:2]) < 60.0)
    assert copter.position_m[2] == pytest.approx(15.0, abs=0.6)
    fly(copter, lambda: hypot(*copter.position_m[:2]) < 0.5)
    over_s = copter.time_s
    fly(copter, lambda: copter.position_m[2] < 14.5)
    assert copter.time_s - over_s > 5.0
    fly(copter, lambda: not copter.motors)
    assert copter.position_m == pytest.approx((0.0, 0.0, 0.0), abs=0.1)


@pytest.mark.parametrize(
    ("start", "changes", "altitude"),
    [
        ((3.0, 0.0, 5.0), {}, 9.0),
        ((3.0, 0.0, 5.0), {"rtl_cone_slope": 0.0}, 15.0),
        ((40.0, 0.0, 25.0), {}, 25.0),
        ((40.0, 0.0, 25.0), {"rtl_climb_min_m": 4.0}, 29.0),
        ((1.0, 0.0, 5.0), {}, 5.0),
    ],
    ids=["cone", "no cone", "higher already", "climb at least", "no descent"],
)
def test_the_return_altitude_follows_its_rules(
    start: Vector, changes: dict[str, float], altitude: float
) -> None:
    """RTL_ALT, but not above the cone around home, at least RTL_CLIMB_MIN higher, and never lower."""
    copter = Copter(replace(LIMITS, **changes), position_m=start)
    copter.return_home()
    places = fly(copter, lambda: not copter.motors)
    assert max(u for _, _, u in places) == pytest.approx(altitude, abs=0.25)


def test_rtl_alt_final_stays_in_the_air() -> None:
    """With RTL_ALT_FINAL the return ends in a hover at that height."""
    copter = Copter(replace(LIMITS, rtl_altitude_final_m=6.0, rtl_loiter_s=1.0), position_m=(10.0, 0.0, 20.0))
    copter.return_home()
    fly(copter, lambda: copter.time_s > 60.0)
    assert copter.motors
    assert copter.position_m == pytest.approx((0.0, 0.0, 6.0), abs=0.1)


def test_the_nose_follows_the_path_to_waypoints_but_not_home() -> None:
    """WP_YAW_BEHAVIOR 2: ahead on the way out, as it was on the way back."""
    copter = hover(yaw_rad=pi / 2)
    copter.follow(GuidedTarget(position_m=(-60.0, 0.0, 20.0)))
    fly(copter, lambda: copter.position_m[0] < -30.0)
    assert abs(degrees(copter.attitude_rad[2])) == pytest.approx(180.0, abs=2.0)
    copter.return_home()
    fly(copter, lambda: copter.position_m[2] < 10.0)
    assert abs(degrees(copter.attitude_rad[2])) == pytest.approx(180.0, abs=2.0)


def test_a_nose_that_turned_home_turns_back_before_landing() -> None:
    """WP_YAW_BEHAVIOR 1: RTL looks home, and lands with the heading of arming."""
    copter = Copter(replace(LIMITS, wp_yaw_behavior=1.0), yaw_rad=1.0)
    copter.takeoff(20.0)
    fly(copter, lambda: copter.submode.done)
    copter.follow(GuidedTarget(position_m=(0.0, 40.0, 20.0)))
    fly(copter, lambda: copter.submode.done)
    copter.return_home()
    fly(copter, lambda: copter.position_m[1] < 20.0)
    assert degrees(copter.attitude_rad[2]) == pytest.approx(-90.0, abs=3.0)
    fly(copter, lambda: not copter.motors)
    assert copter.attitude_rad[2] == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize(("behavior", "heading"), [(0.0, 30.0), (3.0, 90.0)])
def test_other_yaw_behaviours(behavior: float, heading: float) -> None:
    """WP_YAW_BEHAVIOR 0 never turns, 3 looks along the flown path."""
    copter = Copter(replace(LIMITS, wp_yaw_behavior=behavior), position_m=(0, 0, 20), yaw_rad=pi / 6)
    copter.follow(GuidedTarget(position_m=(0.0, 60.0, 20.0)))
    fly(copter, lambda: copter.position_m[1] > 30.0)
    assert degrees(copter.attitude_rad[2]) == pytest.approx(heading, abs=2.0)


def test_leaning_is_what_moves_it() -> None:
    """Accelerating north with the nose east leans to the left; the lean keeps to ANGLE_MAX."""
    copter = Copter(replace(LIMITS, wp_yaw_behavior=0.0), position_m=(0, 0, 20), yaw_rad=pi / 2)
    copter.follow(GuidedTarget(position_m=(200.0, 0.0, 20.0)))
    fly(copter, lambda: copter.position_m[0] > 10.0)
    roll, pitch, _ = copter.attitude_rad
    assert roll < -0.1
    assert abs(pitch) < 0.05
    worst = 0.0
    while copter.position_m[0] < 150.0:
        copter.step()
        worst = max(worst, hypot(*copter.attitude_rad[:2]))
    assert degrees(worst) <= 30.5


def test_wind_is_leaned_against() -> None:
    """Hovering in 6 m/s of wind from the north, it stays in place leaning north, and lands at home."""
    copter = hover(wind_m_s=(-6.0, 0.0, 0.0))
    copter.hold()
    fly(copter, lambda: copter.time_s > 30.0)
    assert hypot(*copter.velocity_m_s) < 0.05
    assert copter.attitude_rad[1] < -0.1
    copter.return_home()
    fly(copter, lambda: not copter.motors)
    assert hypot(*copter.position_m[:2]) < 0.5


def test_a_step_of_another_length_flies_the_same() -> None:
    """10 ms and 40 ms steps agree on a flight to a position."""
    ends = []
    for step_s in (0.01, 0.04):
        copter = hover(step_s=step_s)
        copter.follow(GuidedTarget(position_m=(30.0, 20.0, 25.0)))
        fly(copter, lambda c=copter: c.time_s > 6.0)  # type: ignore[misc]
        ends.append(copter.position_m)
    assert ends[0] == pytest.approx(ends[1], abs=0.15)


def test_a_fixed_heading_is_turned_to_at_the_given_rate() -> None:
    """set_yaw() turns the given way round, relative or absolute, and no faster than told."""
    copter = hover()
    copter.set_yaw(pi / 2, 0.2, -1.0)
    fly(copter, lambda: copter.time_s > 5.0)
    assert copter.attitude_rad[2] == pytest.approx(-1.0, abs=0.15)
    fly(copter, lambda: copter.time_s > 30.0)
    assert (cos(copter.attitude_rad[2]), sin(copter.attitude_rad[2])) == pytest.approx((0.0, 1.0), abs=0.02)
    copter.set_yaw(pi / 2, relative=True)
    fly(copter, lambda: copter.time_s > 40.0)
    assert abs(copter.attitude_rad[2]) == pytest.approx(pi, abs=0.01)


def test_changed_limits_hold_from_then_on() -> None:
    """A lower waypoint speed set in flight is kept on the next leg."""
    copter = hover()
    copter.change_limits(replace(LIMITS, wp_speed_m_s=3.0))
    copter.change_speed(1, 3.0)
    copter.follow(GuidedTarget(position_m=(80.0, 0.0, 20.0)))
    fastest = 0.0
    while not copter.submode.done:
        copter.step()
        fastest = max(fastest, hypot(*copter.velocity_m_s))
    assert 2.5 < fastest < 3.3


def test_limits_of_zero_are_none() -> None:
    """Without limits of lean and yaw acceleration, and with one of the lean rate, it flies as well."""
    limits = Limits.from_parameters({"ATC_ACCEL_R_MAX": 0, "ATC_ACCEL_Y_MAX": 0, "ATC_RATE_R_MAX": 60})
    copter = Copter(limits, position_m=(0, 0, 20))
    copter.follow(GuidedTarget(position_m=(0.0, 40.0, 20.0)))
    fly(copter, lambda: copter.submode.done)
    assert copter.attitude_rad[2] == pytest.approx(pi / 2, abs=0.05)


def test_speed_changes_reach_what_is_under_way() -> None:
    """A GUIDED flight takes a new speed, up and level; a landing takes none."""
    copter = hover()
    copter.follow(GuidedTarget(position_m=(100.0, 0.0, 20.0)))
    assert copter.change_speed(1, 2.0)
    assert copter.change_speed(2, 0.5)
    fly(copter, lambda: copter.time_s > 10.0)
    assert hypot(*copter.velocity_m_s) == pytest.approx(2.0, abs=0.1)
    copter.land()
    assert not copter.change_speed(1, 5.0)
