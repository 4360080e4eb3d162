"""A row of straight legs is timed without flying it, and agrees with the flight."""

import numpy as np
import pytest

from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.mission.items import Home, Mission, waypoint
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.flight.trajectory import simulate
from flight_replay.simulator.navigation.leg_durations import straight_duration_s

FRAME = LocalFrame(47.0, 8.0)


def winding(legs: int, leg_m: float, seed: int) -> list[tuple[float, float, float]]:
    """Places of a way that turns at random."""
    turns = np.random.default_rng(seed).normal(0, 0.7, legs).cumsum()
    steps = leg_m * np.column_stack([np.cos(turns), np.sin(turns)])
    north_east_m = np.concatenate([np.zeros((1, 2)), steps.cumsum(axis=0)])
    return [(float(n), float(e), 30.0) for n, e in north_east_m]


@pytest.mark.parametrize(
    ("leg_m", "seed", "limits"),
    [
        (1.0, 1, Limits()),
        (3.0, 2, Limits()),
        (3.0, 3, Limits()),
        (5.5, 4, Limits()),
        (20.0, 5, Limits(wp_speed_m_s=3.0)),
        (20.0, 5, Limits(wp_speed_m_s=3.0, late_corners=1.0)),
    ],
)
def test_legs_take_as_long_as_they_are_flown(leg_m: float, seed: int, limits: Limits) -> None:
    """Within 2 % of the model that flies them step by step, by either rule for corners."""
    places = winding(40, leg_m, seed)
    lat, lon = FRAME.to_degrees([item_at[:2] for item_at in places])
    items = tuple(waypoint(float(a), float(b), 30.0) for a, b in zip(lat, lon, strict=True))
    begin_s, end_s = simulate(Mission(items, Home(47.0, 8.0, 400.0)), limits).auto_s
    assert straight_duration_s(places, limits) == pytest.approx(end_s - begin_s, rel=0.02)


@pytest.mark.parametrize("places", [[], [(0.0, 0.0, 30.0)], [(1.0, 2.0, 30.0)] * 3])
def test_no_way_takes_no_time(places: list[tuple[float, float, float]]) -> None:
    """No position, one, and the same one again and again."""
    assert straight_duration_s(places, Limits()) == 0
