"""A made-up replay for the tests of output: a figure of eight, flown late and beside the path."""

from __future__ import annotations

import numpy as np

from flight_replay.events import VehicleState
from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.logs.track import Track, track_from_columns
from flight_replay.output.outcome import Outcome, compare_flight
from flight_replay.planning.following.followed_route import FollowOptions, followed_route
from flight_replay.planning.route import Route
from flight_replay.planning.spacing import spaced_route
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.supervisor.flight_plan import FlightRecord

FRAME = LocalFrame(47.3977, 8.5456)


def figure_of_eight(n: int = 300, aside_m: float = 0.0, begin_s: float = 100.0, slower: float = 1.0) -> Track:
    """A figure of eight of 120 m by 60 m, n fixes 0.4 s apart."""
    turn = np.linspace(0, 2 * np.pi, n)
    north_east_m = np.column_stack([30 * np.sin(2 * turn) + aside_m * np.cos(5 * turn), 60 * np.sin(turn)])
    time_s = begin_s + 0.4 * slower * np.arange(n, dtype=float)
    lat_deg, lon_deg = FRAME.to_degrees(north_east_m)
    velocity_m_s = np.zeros((n, 3))
    velocity_m_s[:, :2] = np.gradient(north_east_m, time_s, axis=0)
    return track_from_columns(
        time_s, lat_deg, lon_deg, 20 + 5 * np.sin(turn), amsl_m=np.full(n, 500.0), velocity_m_s=velocity_m_s
    )


def made_replay() -> tuple[Route, Outcome]:
    """The figure of eight in 60 waypoints, flown 10 % slower and 1 m aside, all but the last reached."""
    route = spaced_route(figure_of_eight(), spacing_m=6.0, max_points=60)
    flown = figure_of_eight(aside_m=1.0, begin_s=1000.0, slower=1.1)
    record = FlightRecord(
        waypoints_reached=len(route.mission.waypoints) - 1,
        ended="duration",
        problem=None,
        auto_start_s=999.0,
        auto_s=60.0,
        rtl_confirmed=True,
        landed=False,
        reached=tuple((seq, 1000.0 + 2.0 * seq) for seq, _ in route.mission.waypoints[:-1]),
        flown=flown,
    )
    return route, compare_flight(route, record)


def made_following(
    *,
    waits_at_s: float = np.inf,
    waits_s: float = 0.0,
    back_s: float = 0.0,
    end_s: float = 110.0,
    pace: float = 1.0,
) -> tuple[Route, Outcome]:
    """The figure of eight followed in GUIDED, a metre north of its reference.

    Args:
        waits_at_s: the recording's time at which it waits.
        waits_s: for how long.
        back_s: how far it goes back after that.
        end_s: the recording's time at which the flight ends.
        pace: how many times as fast as recorded it is followed.
    """
    track = figure_of_eight()
    route = followed_route(track, np.full(len(track), 30.0), Limits(), FollowOptions(pace=pace))
    assert route.reference is not None
    began_s = -route.reference.begin_s
    since_s = np.arange(0.0, end_s + began_s + waits_s + back_s, 0.1)
    free_s = since_s - began_s
    recording_s = np.where(
        free_s < waits_at_s, free_s, np.maximum(free_s - waits_s, waits_at_s) - back_s * (free_s > waits_at_s)
    )
    places_m = route.reference.positions_m(recording_s) + np.array([1.0, 0.0, 0.0])
    lat_deg, lon_deg = route.reference.frame.to_degrees(places_m[:, :2])
    record = FlightRecord(
        waypoints_reached=0,
        ended="duration",
        problem=None,
        auto_start_s=1000.0,
        auto_s=float(since_s[-1]),
        rtl_confirmed=True,
        landed=False,
        reached=(),
        flown=track_from_columns(1000.0 + since_s, lat_deg, lon_deg, places_m[:, 2]),
        recording_s=recording_s,
    )
    return route, compare_flight(route, record)


def vehicle_at(
    north_m: float, east_m: float, time_s: float, *, mode: str = "AUTO", heading_deg: float | None = 90.0
) -> VehicleState:
    """The state of a vehicle at a position of ``FRAME``."""
    lat_deg, lon_deg = FRAME.to_degrees([north_m, east_m])
    return VehicleState(
        time_s, float(lat_deg), float(lon_deg), 29.8, (3.0, 4.0, 0.0), heading_deg, mode, True, 12.4, 83.0
    )
