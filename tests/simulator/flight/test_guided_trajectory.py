"""Streams of targets that the model flies, and what it does with each kind."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from flight_replay.geometry.arrays import Floats
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.flight.guided_trajectory import Targets, simulate_targets
from flight_replay.simulator.flight.trajectory import Trajectory

LIMITS = Limits()
TIMES = np.arange(0.0, 20.0, 0.1)


def column(*values: float) -> Floats:
    """The same row for every time."""
    return np.tile(np.array(values), (len(TIMES), 1))


def lemniscate(times: Floats, rate_rad_s: float = 0.4) -> tuple[Floats, Floats, Floats]:
    """An eight, 20 m long, from rest: position, velocity and acceleration."""
    phase = rate_rad_s * np.where(times < 5.0, times**2 / 10.0, times - 2.5)
    turn = rate_rad_s * np.minimum(times / 5.0, 1.0)
    spin = np.where(times < 5.0, rate_rad_s / 5.0, 0.0)
    level = np.zeros_like(times)
    position = np.column_stack([10 * np.sin(phase), 5 * np.sin(2 * phase), level + 30])
    along = np.column_stack([10 * np.cos(phase), 10 * np.cos(2 * phase), level])
    bend = np.column_stack([-10 * np.sin(phase), -20 * np.sin(2 * phase), level])
    return position, along * turn[:, None], bend * turn[:, None] ** 2 + along * spin[:, None]


def errors_m(flown: Trajectory, times: Floats, position_m: Floats) -> Floats:
    """Distance from the targets at equal times."""
    there = np.column_stack([np.interp(flown.time_s, times, position_m[:, axis]) for axis in range(3)])
    here = np.column_stack([flown.north_m, flown.east_m, flown.up_m])
    distances: Floats = np.sqrt(((here - there) ** 2).sum(axis=1))
    return distances


def test_position_velocity_and_acceleration_together_are_followed_closely() -> None:
    """With all three, the copter lags by little; with the position alone, by metres."""
    times = np.arange(100.0, 130.0, 0.1)
    position, velocity, accel = lemniscate(times - 100.0)
    full = simulate_targets(Targets(times, position, velocity, accel), LIMITS)
    assert full.time_s[0] == 100.0
    assert full.time_s[-1] == pytest.approx(times[-1], abs=0.021)
    assert full.auto_s == (100.0, times[-1])
    alone = errors_m(simulate_targets(Targets(times, position), LIMITS), times, position)
    assert errors_m(full, times, position).max() < 0.8
    assert alone.mean() > 2.0


def test_it_begins_where_it_is_told() -> None:
    """At rest at the first position, or anywhere with any motion; the heading is the first one sent."""
    targets = Targets(TIMES, column(3.0, 4.0, 30.0), yaw_rad=np.full(len(TIMES), 1.0))
    hovering = simulate_targets(targets, LIMITS)
    assert hovering.heading_deg == pytest.approx(np.degrees(1.0), abs=0.1)
    assert hovering.north_m == pytest.approx(3.0, abs=0.01)
    moving = simulate_targets(
        targets, LIMITS, start_m=(0.0, 0.0, 20.0), velocity_m_s=(2.0, 0.0, 0.0), yaw_rad=0.0
    )
    assert (moving.up_m[0], moving.north_m_s[0], moving.heading_deg[0]) == (20.0, 2.0, 0.0)
    assert (moving.north_m[-1], moving.east_m[-1], moving.up_m[-1]) == pytest.approx(
        (3.0, 4.0, 30.0), abs=0.2
    )


def test_a_velocity_is_flown_until_it_is_too_old() -> None:
    """GUID_TIMEOUT after the last one the copter brakes, and stays where it comes to rest."""
    targets = Targets(TIMES, velocity_m_s=column(4.0, 0.0, 0.0))
    limits = replace(LIMITS, guided_timeout_s=0.5)
    flown = simulate_targets(targets, limits, start_m=(0.0, 0.0, 30.0), after_s=15.0)
    at_end = np.searchsorted(flown.time_s, TIMES[-1])
    assert flown.north_m_s[at_end] == pytest.approx(4.0, abs=0.05)
    assert flown.north_m[-1] - flown.north_m[at_end] == pytest.approx(2.0 + 5.5, abs=2.5)
    assert abs(flown.north_m_s[-1]) < 0.02


def test_a_gap_goes_on_with_velocity_and_acceleration() -> None:
    """Between targets the goal moves on as the last one had it."""
    once = Targets(
        np.array([0.0, 2.5]),
        np.array([[0.0, 0, 30]] * 2),
        np.array([[0.0, 1, 0]] * 2),
        np.array([[1.0, 0, 0]] * 2),
    )
    flown = simulate_targets(once, LIMITS)
    assert flown.north_m_s[-1] == pytest.approx(2.3, abs=0.3)
    assert flown.east_m_s[-1] == pytest.approx(1.0, abs=0.2)


def test_an_acceleration_alone_is_flown_and_then_the_copter_stops() -> None:
    """After GUID_TIMEOUT it comes to rest."""
    targets = Targets(np.array([0.0]), acceleration_m_s2=np.array([[1.0, 0.0, 0.3]]))
    flown = simulate_targets(targets, LIMITS, start_m=(0.0, 0.0, 30.0), after_s=15.0)
    assert flown.north_m_s.max() == pytest.approx(2.9, abs=0.4)
    assert flown.up_m[-1] > 31.0
    assert abs(flown.north_m_s[-1]) < 0.02


def test_rows_that_are_not_numbers_leave_a_group_out() -> None:
    """One axis that is missing makes a stream of positions and velocities one of velocities."""
    position = column(50.0, 0.0, 30.0)
    position[:, 1] = np.nan
    flown = simulate_targets(
        Targets(TIMES, position, column(1.0, 0.0, 0.0)), LIMITS, start_m=(0.0, 0.0, 30.0)
    )
    assert flown.north_m_s[-1] == pytest.approx(1.0, abs=0.05)
    assert flown.north_m[-1] < 21.0


@pytest.mark.parametrize(
    ("yaw", "rate", "late_deg"), [(True, True, 0.0), (True, False, 6.5), (False, True, 2.0)]
)
def test_headings_and_yaw_rates_turn_it(yaw: bool, rate: bool, late_deg: float) -> None:
    """Angle and rate follow a turning heading, an angle alone lags, a rate alone turns from where it is."""
    turning = 0.5 * TIMES
    targets = Targets(
        TIMES,
        column(0.0, 0.0, 30.0),
        column(0.0, 0.0, 0.0),
        yaw_rad=turning if yaw else None,
        yaw_rate_rad_s=np.full(len(TIMES), 0.5) if rate else None,
    )
    flown = simulate_targets(targets, LIMITS)
    late = np.degrees(0.5 * flown.time_s[-1]) - np.degrees(np.unwrap(np.radians(flown.heading_deg))[-1])
    assert late == pytest.approx(late_deg, abs=2.5)


def test_yaw_rates_keep_to_the_slew_limit_and_stop_with_the_stream() -> None:
    """No faster than ATC_SLEW_YAW; GUID_TIMEOUT after the last target the turn ends."""
    fast = np.full(len(TIMES), 5.0)
    targets = Targets(TIMES, column(0.0, 0.0, 30.0), column(0.0, 0.0, 0.0), yaw_rate_rad_s=fast)
    heading = np.unwrap(np.radians(simulate_targets(targets, LIMITS, after_s=10.0).heading_deg))
    rates = np.diff(heading) / 0.02
    assert rates[500:900].mean() == pytest.approx(pi / 3, rel=0.01)
    assert rates.max() < 1.2 * pi / 3
    assert abs(rates[-1]) < 0.01


@pytest.mark.parametrize("option", [16, 32])
def test_guid_options_give_up_corrections(option: int) -> None:
    """Without correction of position, or of velocity too, the copter does not come to the targets' place."""
    limits = replace(LIMITS, guided_options=float(option))
    targets = Targets(TIMES, column(0.0, 0.0, 30.0), column(0.0, 0.0, 0.0))
    held = simulate_targets(targets, LIMITS, start_m=(2.0, 0.0, 29.0))
    driven = simulate_targets(targets, limits, start_m=(2.0, 0.0, 29.0))
    assert (held.north_m[-1], held.up_m[-1]) == pytest.approx((0.0, 30.0), abs=0.05)
    assert (driven.north_m[-1], driven.up_m[-1]) == pytest.approx((2.0, 30.0), abs=0.05)


def test_a_hover_in_wind_begins_leaning() -> None:
    """A copter that has hovered in the wind before is not blown off when the stream begins."""
    targets = Targets(TIMES, column(0.0, 0.0, 30.0), column(0.0, 0.0, 0.0))
    flown = simulate_targets(targets, LIMITS, wind_m_s=(5.0, -3.0, 0.0))
    assert np.abs(flown.north_east_m).max() < 0.05


def test_steps_of_any_length_fly_the_same() -> None:
    """A step of 10 ms and one of 20 ms agree within centimetres."""
    times = np.arange(0.0, 30.0, 0.1)
    position, velocity, accel = lemniscate(times)
    ends = [
        simulate_targets(Targets(times, position, velocity, accel), LIMITS, step_s=step_s)
        for step_s in (0.01, 0.02)
    ]
    fine = np.interp(ends[1].time_s, ends[0].time_s, ends[0].north_m)
    assert fine == pytest.approx(ends[1].north_m, abs=0.1)
