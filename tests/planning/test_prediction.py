"""What the model of ArduCopter says of a route before it is flown."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.planning import prediction
from flight_replay.planning.prediction import with_prediction
from flight_replay.planning.spacing import spaced_route
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.flight.trajectory import simulate_flight
from tests.helpers.fit_tracks import along, draft_of


def test_a_route_is_predicted_both_ways() -> None:
    """Along a square at 4 m/s the copter cuts corners by less than 2 m, and flies at 30 m."""
    track = along([(0, 0), (60, 0), (60, 60), (0, 60)], 4.0)
    route = with_prediction(spaced_route(track, spacing_m=19.9), 30.0)
    assert route.predicted is not None
    path = route.predicted.path_m
    assert 0 < path.recorded_to_path.error.max() < 2.0
    assert 0 < path.path_to_recorded.error.max() < 2.0
    assert route.predicted.height_m.error.max() < 1.0
    assert len(route.predicted.position_m) > 100
    assert len(route.predicted.heading_deg) == 0


def test_a_route_that_is_too_long_is_not_predicted(monkeypatch: pytest.MonkeyPatch) -> None:
    """It would take minutes to simulate."""
    monkeypatch.setattr(prediction, "LONGEST_SIMULATED_M", 10.0)
    assert with_prediction(spaced_route(along([(0, 0), (60, 0)], 4.0)), 30.0).predicted is None


def test_a_flight_that_does_not_end_is_not_predicted(monkeypatch: pytest.MonkeyPatch) -> None:
    """The route stays as it is."""
    monkeypatch.setattr("flight_replay.simulator.flight.trajectory._LONGEST_S", 1.0)
    assert with_prediction(spaced_route(along([(0, 0), (60, 0)], 4.0)), 30.0).predicted is None


@pytest.mark.parametrize("takeoff_m", [10.0, 30.0, 60.0])
def test_the_time_in_auto_is_that_of_a_whole_flight(takeoff_m: float) -> None:
    """With the climb, or descent, from the take-off to the first waypoint."""
    route = spaced_route(along([(0, 0), (60, 0), (60, 60)], 4.0), spacing_m=19.9)
    begin_s, end_s = simulate_flight(route.mission, Limits(), takeoff_m=takeoff_m).auto_s
    predicted_s = with_prediction(route, takeoff_m).predicted_duration_s
    assert predicted_s == pytest.approx(end_s - begin_s, abs=1.0)


def test_a_mission_with_a_leg_that_ardupilot_does_not_plan_is_told() -> None:
    """4.6 reported an internal error on such a leg, and did not arm again."""
    corners = [(0.0, 0.0), (-0.31, -0.28), (-4.65, -0.17), (-1.88, -3.93), (0.98, -5.23)]
    draft = draft_of(corners, [False, False, True, True, True], [6, 0, 0, 0, 0])
    asked = replace(draft, speed_m_s=np.array([np.nan, 0.35, 1.19, 2.23, 2.65]))
    route = spaced_route(along(corners, 1.0))
    longer_m = draft.places_m.copy()
    longer_m[1] *= 2.0
    bad, good = (
        with_prediction(replace(route, mission=each.mission(FlatFrame(47.3, 8.5), Limits())), 20.0)
        for each in (asked, replace(asked, places_m=longer_m))
    )
    assert any("reports an internal error on a short straight leg" in note for note in bad.notes)
    assert good.notes == route.notes
