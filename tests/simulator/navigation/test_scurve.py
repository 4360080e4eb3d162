"""Straight legs keep to their limits, end where they should, and last as long as formulas say."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flight_replay.simulator.navigation.path_limits import PathLimits
from flight_replay.simulator.navigation.scurve import SCurve

SHARE, SPEED = st.floats(0.0, 1.0), st.floats(0.5, 12.0)
LIMITS = PathLimits(10.0, 2.5, 1.5, 2.5, 1.0, 1.0, pi / 0.6)


def motion(leg: SCurve, count: int = 400) -> np.ndarray:
    """Time, position, speed and acceleration along a leg, shape (4, count)."""
    times = np.linspace(0.0, leg.end_time, count)
    return np.column_stack([[t, *leg.at(t)] for t in times])


def some_limits(speed: float, accel: float, jerk: float) -> PathLimits:
    return PathLimits(speed, 2.5, 1.5, accel, 1.0, jerk, jerk * pi / 0.6)


@settings(max_examples=60)
@given(st.floats(0.02, 300.0), st.floats(0.3, 20.0), st.floats(0.5, 5.0), st.floats(0.5, 20.0))
def test_a_leg_goes_from_rest_to_rest_within_its_limits(
    length: float, speed: float, accel: float, jerk: float
) -> None:
    """Whatever length and limits: it ends at rest at its length, and exceeds nothing on the way."""
    leg = SCurve((length, 0.0, 0.0), some_limits(speed, accel, jerk))
    time, position, flown, pushed = motion(leg)
    assert position[-1] == pytest.approx(length, rel=1e-6)
    assert flown[-1] == pytest.approx(0.0, abs=1e-6)
    assert flown.max() <= speed * (1 + 1e-6)
    assert np.abs(pushed).max() <= accel * (1 + 1e-6)
    assert np.abs(np.diff(pushed) / np.diff(time)).max() <= jerk * (1 + 1e-3)
    assert (np.diff(position) >= -1e-9).all()


def test_acceleration_is_confined_to_half_the_leg() -> None:
    """The speed is gained within the first half of a leg, however short."""
    for length in (0.5, 3.0, 20.0, 60.0):
        leg = SCurve((length, 0.0, 0.0), LIMITS)
        _, position, speed, _ = motion(leg, 2001)
        assert speed[position <= length / 2].max() == pytest.approx(speed.max(), rel=1e-3)


PEAKS = [(3, 1.2), (5, 1.7), (10, 2.8), (20, 4.4), (30, 5.8), (50, 8.2), (80, 10)]


@pytest.mark.parametrize(("length", "peak"), PEAKS)
def test_short_legs_are_slow(length: float, peak: float) -> None:
    """Peak speeds at the default parameters are those that ArduCopter 4.6 shows."""
    speed = motion(SCurve((0.0, float(length), 0.0), LIMITS))[2]
    assert speed.max() == pytest.approx(peak, abs=0.06)


def test_a_long_leg_lasts_as_the_closed_form_says() -> None:
    """length / v + v / a + a / jerk + the rise of the jerk, jerk pi / (2 snap)."""
    leg = SCurve((150.0, 0.0, 0.0), LIMITS)
    assert leg.end_time == pytest.approx(150 / 10 + 10 / 2.5 + 2.5 / 1.0 + pi / (2 * pi / 0.6))


def test_climbs_go_by_their_own_limits() -> None:
    """A leg straight up keeps to the climb speed and the vertical acceleration."""
    leg = SCurve((0.0, 0.0, 30.0), LIMITS)
    _, _, speed, accel = motion(leg)
    assert leg.direction == (0.0, 0.0, 1.0)
    assert speed.max() == pytest.approx(2.5)
    assert accel.max() == pytest.approx(1.0)
    assert motion(SCurve((0.0, 0.0, -30.0), LIMITS))[2].max() == pytest.approx(1.5)


def test_a_leg_without_length_is_over_at_once() -> None:
    """It is empty and finished, lasts no time, and takes no speed."""
    leg = SCurve((0.0, 0.0, 0.0), LIMITS)
    leg.limit_destination_speed(1.0)
    leg.change_speed(LIMITS)
    assert leg.empty
    assert leg.finished
    assert leg.limit_origin_speed(3.0) == 0.0
    assert (leg.end_time, leg.turn_in_time, leg.turn_out_time) == (0.0, 0.0, 0.0)


def test_a_leg_may_start_and_end_at_a_speed() -> None:
    """Speeds at the ends are taken up to the leg's peak, and the length stays."""
    leg = SCurve((120.0, 0.0, 0.0), LIMITS)
    assert leg.limit_origin_speed(4.0) == 4.0
    assert leg.limit_origin_speed(4.0) == 4.0
    leg.limit_destination_speed(3.0)
    leg.limit_destination_speed(3.0)
    _, position, speed, accel = motion(leg)
    assert speed[0] == pytest.approx(4.0)
    assert speed[-1] == pytest.approx(3.0, abs=1e-6)
    assert position[-1] == pytest.approx(120.0)
    assert accel.max() <= 2.5 + 1e-9
    assert leg.limit_origin_speed(99.0) == pytest.approx(speed.max())


def test_a_start_too_fast_for_a_ramp_leaves_the_speed_as_it_is() -> None:
    """ArduPilot finds no ramp on a short leg entered fast, and flies it at constant speed."""
    leg = SCurve((1.1, 0.0, 0.0), LIMITS)
    leg.limit_origin_speed(0.4)
    speed = motion(leg)[2]
    assert speed.max() == pytest.approx(0.4)


@settings(max_examples=60)
@given(st.floats(20.0, 200.0), SHARE, SPEED, SHARE, SPEED)
def test_a_changed_speed_neither_jumps_nor_misses_the_end(
    length: float, when: float, speed: float, again: float, other: float
) -> None:
    """Two changes anywhere on the way: position, speed and acceleration go on smoothly to the end."""
    leg = SCurve((length, 0.0, 0.0), LIMITS)
    for share, new in ((when, speed), (again, other)):
        leg.advance(share * (leg.end_time - leg.time))
        before = leg.at(leg.time)
        leg.change_speed(some_limits(new, 2.5, 1.0))
        assert leg.at(leg.time) == pytest.approx(before, abs=1e-3)
        assert leg.top_speed == new
    assert leg.at(leg.end_time)[0] == pytest.approx(length, rel=1e-3)
    assert leg.at(leg.end_time)[1] == pytest.approx(0.0, abs=1e-3)


def test_a_lower_speed_is_reached_where_there_is_room() -> None:
    """A change in the cruise ramps to the new speed; one without room leaves the old one."""
    leg = SCurve((200.0, 0.0, 0.0), LIMITS)
    leg.advance(8.0)
    leg.change_speed(some_limits(4.0, 2.5, 1.0))
    speeds = [leg.at(t)[1] for t in np.linspace(leg.time, leg.end_time, 200)]
    assert speeds[100] == pytest.approx(4.0)
    leg.change_speed(some_limits(6.0, 2.5, 1.0))
    leg.advance(6.0)
    leg.change_speed(some_limits(7.0, 2.5, 1.0))
    assert max(leg.at(t)[1] for t in np.linspace(leg.time, leg.end_time, 300)) == pytest.approx(7.0, abs=0.05)
    short = SCurve((10.0, 0.0, 0.0), LIMITS)
    short.advance(2.5)
    end = short.end_time
    short.change_speed(some_limits(1.0, 2.5, 1.0))
    assert short.end_time == end


def test_a_change_before_the_start_plans_anew() -> None:
    """A leg that has not begun takes the new speed from the beginning, and keeps the ends' speeds."""
    leg = SCurve((100.0, 0.0, 0.0), LIMITS)
    leg.limit_origin_speed(5.0)
    leg.change_speed(some_limits(3.0, 2.5, 1.0))
    speed = motion(leg)[2]
    assert speed[0] == pytest.approx(3.0)
    assert speed.max() == pytest.approx(3.0)


def test_braking_is_not_replanned() -> None:
    """A change while the leg brakes alters nothing."""
    leg = SCurve((50.0, 0.0, 0.0), LIMITS)
    leg.advance(leg.turn_out_time + 0.1)
    end = leg.end_time
    leg.change_speed(some_limits(2.0, 2.5, 1.0))
    assert leg.end_time == end


def test_time_outside_the_leg_coasts() -> None:
    """After the end the leg rests there, and before its start it is at its origin."""
    leg = SCurve((10.0, 0.0, 0.0), LIMITS)
    assert leg.at(leg.end_time + 5.0)[0] == pytest.approx(10.0)
    assert leg.at(-1.0) == (0.0, 0.0, 0.0)
    leg.advance(1e9)
    assert leg.finished


def test_a_stop_counts_as_reached_just_before_its_time_is_up() -> None:
    """Within a ten-millionth of its length, some 0.1 s early, the leg is finished."""
    leg = SCurve((40.0, 0.0, 0.0), LIMITS)
    leg.advance(leg.end_time - 0.2)
    assert not leg.finished
    leg.advance(0.16)
    assert leg.finished
    assert leg.time < leg.end_time
    assert leg.position == pytest.approx(40.0, abs=1e-5)


@pytest.mark.parametrize(
    ("speed", "end_speed", "length", "has_error"),
    [
        (0.55, 0.275, 0.68, False),
        (0.55, 0.275, 0.72, True),
        (0.55, 0.275, 0.98, True),
        (0.55, 0.275, 1.03, False),
        (0.35, 0.175, 0.53, False),
        (0.35, 0.175, 0.56, True),
        (0.35, 0.175, 0.64, False),
        (0.35, 0.35, 0.94, False),
        (0.35, 0.35, 1.00, True),
        (0.35, 0.35, 1.07, False),
        (0.35, 0.0, 0.56, False),
    ],
)
def test_some_short_legs_make_ardupilot_report_an_error(
    speed: float, end_speed: float, length: float, has_error: bool
) -> None:
    """As ArduCopter 4.6's own SCurve does, planned at 10 m/s, for an end, and then for a slower speed."""
    leg = SCurve((length, 0.0, 0.0), LIMITS)
    if end_speed > 0:
        leg.limit_destination_speed(end_speed)
    leg.change_speed(replace(LIMITS, speed_m_s=speed))
    assert leg.has_error == has_error
