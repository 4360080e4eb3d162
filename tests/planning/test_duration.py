"""How long a vehicle at its defaults flies a mission in AUTO."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.mission.items import Home, Mission, change_speed
from flight_replay.mission.path import Path, planned_path
from flight_replay.planning.duration import duration_s
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.flight.trajectory import home_frame, simulate
from flight_replay.simulator.navigation.leg_durations import straight_duration_s
from tests.helpers.made_missions import mission_at


def square(side_m: float, *, spline: bool = False) -> Mission:
    """Three sides of a square, 30 m above home."""
    corners = [(0.0, 0.0), (side_m, 0.0), (side_m, side_m), (0.0, side_m)]
    return mission_at([(north, east, 30.0) for north, east in corners], spline=spline)


def path_of(mission: Mission) -> Path:
    return planned_path(mission, home_frame(mission))


def simulated_s(mission: Mission, step_s: float) -> float:
    begin_s, end_s = simulate(mission, Limits(), step_s=step_s).auto_s
    return end_s - begin_s


@pytest.mark.parametrize("side_m", [3.0, 5.9, 6.1, 60.0])
@pytest.mark.parametrize("spline", [False, True])
def test_a_duration_is_that_of_the_flight_model(side_m: float, spline: bool) -> None:
    """Within 2 % of the model in fine steps, or 0.6 s: a vehicle arrives somewhat behind its target."""
    mission = square(side_m, spline=spline)
    flown_s = simulated_s(mission, 0.025)
    assert duration_s(mission, path_of(mission), Limits()) == pytest.approx(flown_s, rel=0.02, abs=0.6)


def test_short_straight_legs_are_timed_by_their_targets_alone() -> None:
    """Up to 6 m, which saves the import of the flight model; longer legs are flown in it."""
    for side_m, by_targets in ((5.9, True), (6.1, False)):
        mission = square(side_m)
        path = path_of(mission)
        corners = [(float(n), float(e), 30.0) for n, e in path.north_east_m]
        assert (duration_s(mission, path, Limits()) == straight_duration_s(corners, Limits())) is by_targets


def test_what_takes_longer_than_batteries_last_is_told_by_its_speeds() -> None:
    """The model is not flown so far: 6 km at 0.4 m/s, and a wait."""
    slow = square(2000.0)
    first, *others = slow.items
    held = replace(others[0], params=(60.0, 0.0, 0.0, 0.0))
    mission = replace(slow, items=(first, change_speed(0.4), held, *others[1:]))
    assert duration_s(mission, path_of(mission), Limits()) == pytest.approx(6000 / 0.4 + 60, rel=0.001)


def test_a_hold_takes_its_time() -> None:
    """Holds on short legs are waited out too."""
    mission = square(5.0)
    held = replace(mission.items[1], params=(7.0, 0.0, 0.0, 0.0))
    waiting = replace(mission, items=(mission.items[0], held, *mission.items[2:]))
    assert (
        duration_s(waiting, path_of(waiting), Limits())
        > duration_s(mission, path_of(mission), Limits()) + 7.0
    )


def test_a_route_beyond_any_copter_is_not_simulated() -> None:
    """Farther than 50 km the duration is that of the length at full speed; a shorter one is simulated."""
    home = Home(0.0, 0.0, 0.0)
    far, near = (mission_at([(0.0, 0.0, 30.0), (north_m, 0.0, 30.0)], home=home) for north_m in (51e3, 49e3))
    assert duration_s(far, path_of(far), Limits()) == path_of(far).length_m / 10.0
    assert duration_s(near, path_of(near), Limits()) > path_of(near).length_m / 10.0 + 1.0


def test_one_waypoint_takes_no_time() -> None:
    """A route that ends where it begins is over at once."""
    mission = mission_at([(0.0, 0.0, 30.0)])
    assert duration_s(mission, path_of(mission), Limits()) == pytest.approx(0.0, abs=0.2)
    assert np.isfinite(path_of(mission).length_m)
