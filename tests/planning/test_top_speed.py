"""A speed that is asked for and not reached is told before the flight."""

from dataclasses import replace
from math import radians

import pytest

from flight_replay.planning.prediction import with_prediction
from flight_replay.planning.spacing import spaced_route
from flight_replay.planning.top_speed import with_speed_note
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import along


def notes(spacing_m: float, speed_m_s: float, limits: Limits | None = None) -> tuple[str, ...]:
    """Those of a route of 600 m straight on."""
    limits = limits or Limits()
    track = along([(0, 0), (600, 0)], 10.0)
    route = spaced_route(track, spacing_m=spacing_m, speed_m_s=speed_m_s, limits=limits)
    return with_speed_note(with_prediction(route, 30.0), speed_m_s).notes


@pytest.mark.parametrize(
    ("limits", "told"),
    [
        (Limits(), "up to 10.2 m/s, not at 20 m/s: at its greatest lean, 30 degrees"),
        (Limits(lean_angle_rad=radians(20)), "up to 7.4 m/s, not at 20 m/s: at its greatest lean, 20"),
    ],
)
def test_what_drag_does_not_allow_is_told(limits: Limits, told: str) -> None:
    """A copter that may lean 30 degrees flew a leg of 400 m in 4.6 at 10.2 m/s, asked for 20."""
    (note,) = notes(500.0, 20.0, limits)
    assert told in note


def test_what_short_legs_do_not_allow_is_told() -> None:
    """Straight legs of some metres are flown slowly, whatever speed is asked for."""
    (note,) = notes(4.9, 9.0)
    assert "m/s, not at 9 m/s: its legs are too short" in note


def test_a_speed_that_is_reached_is_not_told() -> None:
    """For however short a time."""
    assert notes(500.0, 9.0) == notes(4.9, 1.0) == ()


def test_without_a_predicted_flight_nothing_is_told() -> None:
    """Nobody knows how fast it would be."""
    route = with_prediction(spaced_route(along([(0, 0), (60, 0)], 4.0), speed_m_s=20.0), 30.0)
    unknown = replace(route, predicted_flight=None)
    assert with_speed_note(unknown, 20.0) is unknown
