"""A mission as a route: its path, its planned error, and how long it takes."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.logs.track import Armed
from flight_replay.mission.items import Mission, waypoint
from flight_replay.planning.heights import Heights
from flight_replay.planning.route import route_of
from tests.helpers.made_tracks import FRAME, straight_track


def mission_through(north_east_m: list[tuple[float, float]]) -> Mission:
    """Straight waypoints at metres from the track's first fix."""
    lat, lon = FRAME.to_degrees(np.array(north_east_m))
    return Mission(tuple(waypoint(float(a), float(b), 30.0) for a, b in zip(lat, lon, strict=True)))


def test_the_planned_error_is_that_of_the_fixes_from_the_path() -> None:
    """A path that runs from 0 to 5 m beside a recording of 200 m errs by 2.5 m on average, 5 m at most."""
    route = route_of("by hand", mission_through([(0.0, 0.0), (200.0, 5.0)]), straight_track(fixes=51))
    for errors in (route.planned_error.recorded_to_path, route.planned_error.path_to_recorded):
        assert errors.statistics is not None
        assert errors.statistics.mean == pytest.approx(2.5, abs=0.01)
        assert errors.statistics.p95 == pytest.approx(4.75, abs=0.02)
        assert errors.statistics.max == pytest.approx(5.0, abs=0.01)


def test_standing_on_the_ground_is_not_measured() -> None:
    """What a replay is measured with is flown, its clock begins there, its heights are as commanded."""
    armed = np.full(51, Armed.NO, np.int8)
    armed[20:40] = Armed.YES
    track = replace(straight_track(fixes=51), armed=armed)
    mission = mission_through([(0.0, 0.0), (200.0, 0.0)])
    route = route_of("by hand", mission, track, heights=Heights(np.full(51, 30.0), np.full(51, 28.0)))
    assert (len(route.covered), len(route.recorded), len(route.wanted)) == (51, 20, 20)
    assert (route.wanted.time_s[0], route.wanted.time_s[-1]) == (0.0, 19.0)
    assert route.wanted.north_east_m[0] == pytest.approx([80.0, 0.0], abs=0.01)
    assert set(route.wanted.up_m) == {30.0}
    assert set(route.planned_up_m) == {28.0}
    assert set(route.recorded.alt_m) == {0.0}
    assert len(route.planned_error.recorded_to_path) == 20


def test_a_pause_on_the_ground_is_none_in_the_air() -> None:
    """Where nothing tells of arming: what is measured is what was flown, whatever height is wanted."""
    track = straight_track(fixes=60)
    still = np.zeros(60, np.bool_)
    still[20:40] = True
    track = replace(track, north_m_s=np.where(still, 0.0, 4.0))
    mission = mission_through([(0.0, 0.0), (200.0, 0.0)])
    route = route_of("by hand", mission, track, heights=Heights(np.full(60, 30.0), np.full(60, 28.0)))
    assert len(route.recorded) == len(route.wanted) == len(route.planned_up_m) == 40


def test_a_route_holds_what_it_is_made_of() -> None:
    """The mission, the covered fixes, the path and the expected duration; nothing is predicted yet."""
    mission, track = mission_through([(0.0, 0.0), (60.0, 0.0)]), straight_track(fixes=16)
    route = route_of("by hand", mission, track)
    assert (route.method, route.mission, route.covered) == ("by hand", mission, track)
    assert route.path.length_m == pytest.approx(60.0, abs=0.01)
    assert 60.0 / 10.0 < route.predicted_duration_s < 60.0
    assert (route.predicted, dict(route.required_limits), route.notes) == (None, {}, ())
