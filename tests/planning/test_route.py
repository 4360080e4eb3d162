"""A mission as a route: its path, its planned error, and how long it takes."""

import numpy as np
import pytest

from flight_replay.mission.items import Mission, waypoint
from flight_replay.planning.route import route_of
from tests.helpers.made_tracks import FRAME, straight_track


def mission_through(north_east_m: list[tuple[float, float]]) -> Mission:
    """Straight waypoints at metres from the track's first fix."""
    lat, lon = FRAME.to_degrees(np.array(north_east_m))
    return Mission(tuple(waypoint(float(a), float(b), 30.0) for a, b in zip(lat, lon, strict=True)))


def test_the_planned_error_is_that_of_the_fixes_from_the_path() -> None:
    """A path that runs from 0 to 5 m beside a recording of 200 m errs by 2.5 m on average, 5 m at most."""
    route = route_of("by hand", mission_through([(0.0, 0.0), (200.0, 5.0)]), straight_track(fixes=51))
    assert route.planned_error.mean == pytest.approx(2.5, abs=0.01)
    assert route.planned_error.p95 == pytest.approx(4.75, abs=0.02)
    assert route.planned_error.max == pytest.approx(5.0, abs=0.01)


def test_a_route_holds_what_it_is_made_of() -> None:
    """The mission, the covered fixes, the path and the expected duration; nothing is predicted yet."""
    mission, track = mission_through([(0.0, 0.0), (60.0, 0.0)]), straight_track(fixes=16)
    route = route_of("by hand", mission, track)
    assert (route.method, route.mission, route.covered) == ("by hand", mission, track)
    assert route.path.length_m == pytest.approx(60.0, abs=0.01)
    assert 60.0 / 10.0 < route.predicted_duration_s < 60.0
    assert (route.predicted, dict(route.required_limits), route.notes) == (None, {}, ())
