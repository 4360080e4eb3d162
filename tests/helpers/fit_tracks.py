"""Flights and drafts made for the tests of planning."""

from dataclasses import replace
from typing import Any

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.error_statistics import ErrorStatistics
from flight_replay.geometry.flight_errors import Errors, errors_at_equal_times, path_errors
from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.geometry.movement import Movement
from flight_replay.logs.track import COLUMNS, Armed, Track, track_from_columns
from flight_replay.mission.path import planned_path
from flight_replay.planning.fit import FitResult
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.problem import Budget
from flight_replay.planning.fit.reference import LocalTrack, flat_frame
from flight_replay.planning.fit.simulated_draft import SimulatedDraft
from flight_replay.planning.route import movement_of

FRAME = LocalFrame(47.3, 8.5)


def track_through(north_east_m: Floats, time_s: Floats, up_m: float | Floats = 20.0) -> Track:
    """An armed flight through places at times."""
    lat, lon = FRAME.to_degrees(north_east_m)
    heights = np.broadcast_to(np.asarray(up_m, float), len(time_s)).copy()
    armed = np.full(len(time_s), Armed.YES, np.int8)
    return track_from_columns(time_s, lat, lon, heights, amsl_m=heights + 400.0, armed=armed)


def along(corners_m: list[tuple[float, float]], speed_m_s: float, rate_hz: float = 4.0) -> Track:
    """A flight at constant speed along straight lines."""
    corners = np.array(corners_m, float)
    lengths = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1)))
    time_s = np.arange(0.0, lengths[-1] / speed_m_s + 1e-9, 1 / rate_hz)
    there = np.minimum(time_s * speed_m_s, lengths[-1])
    return track_through(np.column_stack([np.interp(there, lengths, axis) for axis in corners.T]), time_s)


def circle(radius_m: float = 15.0, speed_m_s: float = 3.0, laps: float = 1.0, rate_hz: float = 4.0) -> Track:
    """A flight around a circle."""
    time_s = np.arange(0.0, laps * 2 * np.pi * radius_m / speed_m_s, 1 / rate_hz)
    turn = time_s * speed_m_s / radius_m
    return track_through(radius_m * np.column_stack([np.sin(turn), 1 - np.cos(turn)]), time_s)


def eights(laps: int = 10, rate_hz: float = 2.0) -> Track:
    """A figure of eight flown over and over."""
    time_s = np.arange(0.0, laps * 30.0, 1 / rate_hz)
    turn = time_s * 2 * np.pi / 30.0
    return track_through(np.column_stack([20 * np.sin(turn), 10 * np.sin(2 * turn)]), time_s)


def hover(seconds: float = 30.0, wander_m: float = 0.2) -> Track:
    """Standing in the air, as a GPS sees it."""
    time_s = np.arange(0.0, seconds, 0.25)
    places = np.random.default_rng(4).normal(0.0, wander_m / 3, (len(time_s), 2))
    return track_through(places, time_s)


def wander(seed: int, fixes: int = 80, rate_hz: float = 2.0) -> Track:
    """A hand-flown way of smooth turns and changing speed."""
    rng = np.random.default_rng(seed)
    heading = np.cumsum(np.convolve(rng.normal(0, 0.5, fixes), np.ones(4) / 4, "same"))
    speed = 2.5 + 1.5 * np.sin(np.linspace(0, 6, fixes) + rng.uniform(0, 6))
    step = speed[:, None] * np.column_stack([np.cos(heading), np.sin(heading)]) / rate_hz
    return track_through(np.cumsum(step, axis=0) - step[0], np.arange(fixes) / rate_hz)


def joined(*parts: Track) -> Track:
    columns: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in COLUMNS
    }
    return Track(**columns)


def sped_up(track: Track, factor: float) -> Track:
    return replace(track, time_s=track.time_s / factor)


def draft_of(places: list[tuple[float, float]], spline: list[bool], hold: list[float]) -> Draft:
    flat = np.column_stack([np.array(places, float), np.full(len(places), 20.0)])
    return Draft(flat, np.array(spline), np.array(hold), np.full(len(places), np.nan))


def budget(flights: int = 1000) -> Budget:
    """So many flights, whose progress nobody is told."""
    return Budget(flights, lambda done, total: None)


def recording_of(flight: SimulatedDraft) -> LocalTrack:
    """Every tenth position of a draft as the model flew it."""
    some = slice(None, None, 10)
    return LocalTrack(flight.time_s[some], flight.place_m[some, :2], flight.place_m[some, 2])


def places_m(result: FitResult) -> Floats:
    """The waypoints (n, 2) of a fit in ground metres."""
    items = [item for _, item in result.mission.waypoints]
    frame = result.flown.frame
    return frame.to_metres([item.lat_deg for item in items], [item.lon_deg for item in items])


def predicted(result: FitResult) -> Movement:
    """The predicted flight of a fit in ground metres."""
    flight, flown = result.flight, result.flown
    ground_m = flown.frame.to_metres(*flat_frame(flown).to_degrees(flight.place_m[:, :2]))
    return Movement(flight.time_s, ground_m, flight.place_m[:, 2], np.full(len(ground_m), np.nan))


def planned_error(result: FitResult) -> ErrorStatistics:
    """How far the fixes are from the path of a fit as planned."""
    recorded = movement_of(result.flown, result.flown.frame)
    path = planned_path(result.mission, result.flown.frame)
    return _statistics(path_errors(recorded, path.north_east_m).recorded_to_path)


def path_error(result: FitResult) -> ErrorStatistics:
    """How far the fixes are from the path of the predicted flight of a fit."""
    recorded = movement_of(result.flown, result.flown.frame)
    return _statistics(path_errors(recorded, predicted(result).north_east_m).recorded_to_path)


def position_error(result: FitResult) -> ErrorStatistics:
    """How far the fixes are from the predicted flight of a fit at equal times."""
    recorded = movement_of(result.flown, result.flown.frame)
    return _statistics(errors_at_equal_times(recorded, predicted(result))[0])


def _statistics(errors: Errors) -> ErrorStatistics:
    found = errors.statistics
    assert found is not None
    return found


MIXED = draft_of(
    [(0, 0), (10, 2), (18, 10), (30, 8), (31, 20), (45, 22)],
    [False, True, True, False, True, True],
    [1, 0, 0, 0, 2, 0],
)


DIVE = Draft(
    np.array(
        [
            (0, -100, 25),
            (0, -20, 25),
            (0, -12, 25),
            (-2, -14, 20),
            (-4, -17, 10),
            (-10, -8, 10),
            (-12, -20, 10),
        ],
        float,
    ),
    np.array([False] + [True] * 6),
    np.zeros(7),
    np.array([12.0] + [np.nan] * 6),
)
"""At 12 m/s a vehicle is far too fast for the bend into the dive from 20 m to 10 m."""
