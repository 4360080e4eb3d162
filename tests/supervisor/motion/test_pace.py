"""How fast the clock may run for a vehicle with more drag than was planned with."""

from __future__ import annotations

import numpy as np
import pytest

from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.geometry.reference_motion import ReferenceMotion, Thrust, motion_through
from flight_replay.supervisor.motion.pace import Pace

MOST_M_S2 = 5.0


def _pace(speeds_m_s: list[float], thrust: Thrust) -> Pace:
    """Straight on, at these speeds for 10 s each."""
    times_s = np.arange(0.0, 10.0 * len(speeds_m_s), 0.1)
    speed_m_s = np.array(speeds_m_s)[(times_s // 10.0).astype(int)]
    north_m = np.concatenate([[0.0], np.cumsum(speed_m_s[:-1]) * 0.1])
    through = motion_through(times_s, np.column_stack([north_m, 0.0 * north_m, 0.0 * north_m]))
    return Pace(
        ReferenceMotion(
            frame=FlatFrame(47.0, 8.0),
            begin_s=0.0,
            end_s=through.end_s,
            position=through.position,
            thrust=thrust,
        )
    )


def test_it_is_the_recordings_with_the_drag_that_was_planned_with() -> None:
    assert _pace([50.0], Thrust(MOST_M_S2, 0.5, 0.0)).rate(5.0, 1.0) == 1.0


@pytest.mark.parametrize(
    ("thrust", "power"), [(Thrust(MOST_M_S2, 0.5, 0.0), 1), (Thrust(MOST_M_S2, 0.0, 0.0625), 2)]
)
def test_drag_that_is_twice_as_large_takes_a_slower_clock(thrust: Thrust, power: int) -> None:
    """At 8 m/s it is 8 m/s², where the lean gives 5."""
    rate = _pace([8.0], thrust).rate(5.0, 2.0)
    assert 0.9 * MOST_M_S2 < 8.0 * rate**power < MOST_M_S2


def test_the_clock_slows_down_before_it_has_to() -> None:
    pace = _pace([2.0, 8.0], Thrust(MOST_M_S2, 0.5, 0.0))
    rates = [pace.rate(time_s, 2.0) for time_s in np.arange(5.0, 11.0, 0.1)]
    assert rates[0] == 1.0
    assert 0.5 < rates[-1] < 0.63
    assert np.diff(rates).min() > -0.1


def test_a_vehicle_that_hardly_flies_is_not_waited_for_without_end() -> None:
    assert _pace([8.0], Thrust(MOST_M_S2, 0.5, 0.0)).rate(5.0, 50.0) == pytest.approx(0.3)


def test_beyond_its_end_there_is_nothing_to_slow_down_for() -> None:
    assert _pace([8.0], Thrust(MOST_M_S2, 0.5, 0.0)).rate(50.0, 2.0) == 1.0
