"""Where a target leads a vehicle that gets no further one."""

from __future__ import annotations

import numpy as np
import pytest

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.geometry.reference_motion import ReferenceMotion, motion_through
from flight_replay.supervisor.motion.braking_targets import braking_way

BRAKING_M_S2 = 2.0
FRAME = FlatFrame(47.0, 8.0)


def _motion(north_m: Floats, east_m: Floats, times_s: Floats) -> ReferenceMotion:
    through = motion_through(times_s, np.column_stack([north_m, east_m, np.full(len(times_s), 30.0)]))
    return ReferenceMotion(
        frame=FRAME, begin_s=through.begin_s, end_s=through.end_s, position=through.position
    )


def _led_to_m(motion: ReferenceMotion, time_s: float, seconds: float) -> Floats:
    state = motion.state(time_s)
    way = braking_way(motion, time_s, 1.0, BRAKING_M_S2)
    acceleration_m_s2 = state.acceleration_m_s2 - BRAKING_M_S2 * way
    return np.asarray(state.position_m + state.velocity_m_s * seconds + acceleration_m_s2 * seconds**2 / 2)


def test_on_a_straight_way_it_brakes_along_it() -> None:
    times_s = np.arange(0.0, 10.0, 0.25)
    motion = _motion(8.0 * times_s, np.zeros(len(times_s)), times_s)
    assert braking_way(motion, 5.0, 1.0, BRAKING_M_S2) == pytest.approx([1.0, 0.0, 0.0], abs=1e-6)
    assert braking_way(motion, 5.0, 0.5, BRAKING_M_S2) == pytest.approx([0.5, 0.0, 0.0], abs=1e-6)


def test_where_the_turn_ends_it_leads_along_the_way_not_on_in_the_turn() -> None:
    """The turn's acceleration lasts; a target that kept it would lead inwards."""
    times_s = np.arange(0.0, 10.0, 0.05)
    course = np.interp(times_s, [0.0, 5.2, 10.0], [0.0, 5.2, 5.2])
    places = np.cumsum(np.column_stack([np.cos(course), np.sin(course)]) * 4.0 * 0.05, axis=0)
    motion = _motion(places[:, 0], places[:, 1], times_s)
    line_m = motion.positions_m(np.arange(4.9, 6.0, 0.01))
    state = motion.state(5.0)
    kept_m = state.position_m + 0.7 * state.velocity_m_s + 0.7**2 / 2 * state.acceleration_m_s2
    led_m = _led_to_m(motion, 5.0, 0.7)
    off_m, kept_off_m = (np.linalg.norm(line_m - place, axis=1).min() for place in (led_m, kept_m))
    assert kept_off_m > 0.4
    assert off_m < 0.5 * kept_off_m
    assert np.linalg.norm(led_m - state.position_m) < 4.0 * 0.7


def test_where_the_motion_turns_back_it_does_so_no_later() -> None:
    times_s = np.arange(0.0, 10.0, 0.05)
    motion = _motion(-((times_s - 5.0) ** 2), np.zeros(len(times_s)), times_s)
    assert _led_to_m(motion, 4.6, 0.7)[0] == pytest.approx(0.0, abs=0.2)


@pytest.mark.parametrize(("rate", "braking_m_s2"), [(0.0, 2.0), (1.0, 0.0)])
def test_nothing_is_lacking_where_nothing_moves_or_brakes(rate: float, braking_m_s2: float) -> None:
    times_s = np.arange(0.0, 10.0, 0.25)
    motion = _motion(8.0 * times_s, np.zeros(len(times_s)), times_s)
    assert braking_way(motion, 5.0, rate, braking_m_s2) == pytest.approx(np.zeros(3))


def test_heights_are_left_alone() -> None:
    times_s = np.arange(0.0, 10.0, 0.25)
    through = motion_through(times_s, np.column_stack([8.0 * times_s, 0.0 * times_s, np.sin(times_s)]))
    motion = ReferenceMotion(frame=FRAME, begin_s=0.0, end_s=9.75, position=through.position)
    assert braking_way(motion, 5.0, 1.0, BRAKING_M_S2)[2] == 0.0
