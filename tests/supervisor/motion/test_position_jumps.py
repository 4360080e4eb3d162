"""A position that steps is a jump of the estimate only where no velocity leads there."""

from __future__ import annotations

import pytest

from flight_replay.events import VehicleState
from flight_replay.supervisor.motion.position_jumps import PositionJumps, jump_m


def state(time_s: float, north_m: float, speed_m_s: float = 0.0) -> VehicleState:
    return VehicleState(time_s, 47.0 + north_m / 111_194.9, 8.0, 30.0, (speed_m_s, 0, 0), None, "AUTO", True)


@pytest.mark.parametrize(
    ("now", "jumped_m"),
    [
        (state(10.2, 20.0), 20.0),
        (state(10.2, 3.9), 0.0),
        (state(10.2, 20.0, 90.0), 0.0),
        (state(11.0, 6.0), 0.0),
        (state(11.0, 12.0), 12.0),
        (state(12.0, 500.0), 0.0),
        (state(9.0, 500.0), 0.0),
    ],
    ids=["jump", "small", "fast", "turn unseen", "jump within a second", "after a silence", "older"],
)
def test_a_jump_is_what_the_velocity_does_not_explain(now: VehicleState, jumped_m: float) -> None:
    assert jump_m(state(10.0, 0.0), now) == pytest.approx(jumped_m, abs=0.1)


def test_jumps_are_told_once_in_some_seconds_the_largest_of_them() -> None:
    """An estimator that is not sure jumps to and fro."""
    jumps = PositionJumps()
    assert jumps.latest(0.0) == ""
    assert jumps.observe(state(10.0, 0.0), state(10.2, 20.0))
    assert not jumps.observe(state(10.2, 20.0), state(10.4, -10.0))
    assert not jumps.observe(state(10.4, -10.0), state(10.6, -10.0))
    assert jumps.latest(20.0) == "the vehicle's position estimate jumped by 30 m"
    assert jumps.latest(20.5) == ""
    assert jumps.observe(state(30.0, 0.0), state(30.2, 8.0))
    assert jumps.latest(31.0) == "the vehicle's position estimate jumped by 8 m"
