"""airframe.py: how the lean follows its target."""

from math import pi, radians

import pytest

from flight_replay.simulator.dynamics.aerodynamics import Air
from flight_replay.simulator.dynamics.airframe import Airframe
from flight_replay.simulator.dynamics.limits import Limits


def north_m(step_s: float) -> float:
    """How far two seconds of acceleration that rises by 1 m/s² each second take a copter."""
    airframe = Airframe(Limits(), (0.0, 0.0, 100.0), 0.0, Air(), step_s)
    for k in range(round(2.0 / step_s)):
        # Each step is flown with the acceleration that is wanted in its middle.
        airframe.step((k + 0.5) * step_s, 0.0, Limits().hover_throttle)
    return airframe.n


def test_long_steps_lean_as_late_as_short_ones() -> None:
    """The fit's steps of 0.02 s and those on board end 1 cm apart; 15 ms less of lag would make it 4."""
    assert north_m(0.02) == pytest.approx(north_m(0.0025), abs=0.02)


def lean_north(yaw_rad: float, limits: Limits) -> float:
    """The lean after 0.15 s of as much acceleration to the north as a lean allows."""
    airframe = Airframe(limits, (0.0, 0.0, 100.0), yaw_rad, Air(), 0.0025)
    for _ in range(60):
        airframe.step(5.6, 0.0, limits.hover_throttle)
    return airframe.lean_n


def test_roll_and_pitch_have_each_an_acceleration_of_their_own() -> None:
    """With both, as when the nose points elsewhere, a copter leans sooner (AC_AttitudeControl)."""
    ahead, aside, between = (lean_north(yaw_rad, Limits()) for yaw_rad in (0.0, pi / 2, pi / 4))
    assert aside == pytest.approx(ahead)
    assert between > 1.1 * ahead


def test_roll_and_pitch_share_the_highest_rate() -> None:
    """At 30 degrees a second it counts for both together (ang_vel_limit)."""
    slow = Limits(lean_rate_rad_s=radians(30.0))
    leans = [lean_north(yaw_rad, slow) for yaw_rad in (0.0, pi / 2, pi / 4)]
    assert leans == pytest.approx([leans[0]] * 3, rel=0.05)
    assert max(leans) < radians(30.0) * 0.15


def test_the_more_a_copter_leans_the_more_a_turn_changes_its_lean() -> None:
    """On the way from 0.45 to as much the other way it is at 0.205 after 0.15 s, not at 0.23."""
    airframe = Airframe(Limits(), (0.0, 0.0, 100.0), 0.0, Air(), 0.0025)
    for wanted_m_s2, steps in ((4.41, 400), (-4.41, 60)):
        for _ in range(steps):
            airframe.step(wanted_m_s2, 0.0, Limits().hover_throttle)
    assert airframe.target_lean[0] == pytest.approx(0.205, abs=0.01)
