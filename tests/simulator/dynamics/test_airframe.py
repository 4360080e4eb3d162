"""airframe.py: how the lean follows its target."""

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
