"""The data of the live map, collected from events; independent of the server and the page.

The flown position that a recorded fix will be matched to is known only after the flight. The live
path error is therefore flown to recorded: that of the vehicle's position from the recorded path, searched
near its last position. The errors at equal times are those of the report, which has the final values.
"""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass

import numpy as np

from flight_replay.events import Event, Following, Phase, VehicleState, WaypointReached
from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.matching import match_in_order
from flight_replay.geometry.movement import turn_deg
from flight_replay.geometry.polyline import lengths_along_m, nearest_on_segments
from flight_replay.output.charts.series import thin_indices
from flight_replay.output.replay_status import ReplayStatus
from flight_replay.planning.route import Route

_RETURN_MODES = ("RTL", "SMART_RTL", "AUTO_RTL", "LAND")
_PREDICTED_POINTS = 2000
SEARCH_WINDOW_M = 15.0
"""Length of the recorded path that is searched, behind and ahead of the vehicle's last place on it."""


@dataclass(frozen=True, slots=True)
class MapPoint:
    """A position of the vehicle relative to the first fix, and its errors; NaN where not known.

    ``up_m`` is above home. ``elapsed_s`` counts from when the vehicle reached the first waypoint; where it
    follows a recording, it is the recording's time. ``returns`` is whether it is on its way home.
    """

    north_m: float
    east_m: float
    up_m: float
    speed_m_s: float
    returns: bool
    elapsed_s: float
    path_error_m: float
    position_error_m: float
    height_error_m: float
    heading_error_deg: float


@dataclass(frozen=True, slots=True)
class MapTarget:
    """Where the vehicle is to be: a waypoint with its number, or the place of what is followed."""

    north_m: float
    east_m: float
    label: str


class MapData:
    """A listener that turns positions into points of the map; other threads may read them."""

    def __init__(self, route: Route) -> None:
        self._frame = route.frame
        self._wanted = route.wanted
        self._path_error = LivePathError(route.wanted.north_east_m)
        self._reference = route.reference
        self._first_seq = route.mission.waypoints[0][0]
        waypoints = route.mission.waypoints if route.reference is None else ()
        self._waypoints = {seq: (item.lat_deg, item.lon_deg) for seq, item in waypoints}
        home = route.mission.home
        self.home_m = None if home is None else self._place_m(home.lat_deg, home.lon_deg)
        self.route = route
        self.predicted_path_error = _predicted_path_error(route)
        self._armed: bool | None = None
        self._start_s: float | None = None
        self._points: list[MapPoint] = []
        self._lock = threading.Lock()
        self.status = ReplayStatus()

    def listener(self, event: Event) -> None:
        """Add an event to the status, and a position to the points."""
        self.status.update(event)
        if isinstance(event, Following):
            self._start_s = event.time_s - event.recording_s
        if isinstance(event, WaypointReached) and event.seq == self._first_seq and self._start_s is None:
            self._start_s = event.time_s
        if isinstance(event, VehicleState):
            if event.armed and self._armed is False:  # Home is where it is armed.
                self.home_m = self._place_m(event.lat_deg, event.lon_deg)
            self._armed = event.armed
            point = self._point(event)
            with self._lock:
                self._points.append(point)

    def points(self, start: int) -> list[MapPoint]:
        """The points from index ``start`` on."""
        with self._lock:
            return self._points[start:]

    def target(self) -> MapTarget | None:
        """The waypoint that the vehicle flies to, or where it is to be while following; None without one."""
        current, following = self.status.current_waypoint, self.status.following
        if self.status.ended is not None or self.status.phase is Phase.RETURN:
            return None
        if following is not None and self._reference is not None:
            place_m = self._reference.state(self._recording_s(following)).position_m[:2]
            lat_deg, lon_deg = self._reference.frame.to_degrees(place_m)
            return self._target(float(lat_deg), float(lon_deg), "")
        if current is None or current.seq not in self._waypoints:
            return None
        return self._target(*self._waypoints[current.seq], str(current.number))

    def _recording_s(self, following: Following) -> float:
        """The recording's time of the latest position: it goes on between two events, unless it waits."""
        vehicle = self.status.vehicle
        since_s = 0.0 if vehicle is None or following.waiting else max(vehicle.time_s - following.time_s, 0.0)
        return following.recording_s + since_s

    def _target(self, lat_deg: float, lon_deg: float, label: str) -> MapTarget:
        return MapTarget(*self._place_m(lat_deg, lon_deg), label)

    def _place_m(self, lat_deg: float, lon_deg: float) -> tuple[float, float]:
        north_m, east_m = self._frame.to_metres(lat_deg, lon_deg)
        return float(north_m), float(east_m)

    def _point(self, state: VehicleState) -> MapPoint:
        place_m = self._place_m(state.lat_deg, state.lon_deg)
        returns = self.status.phase in (Phase.RETURN, Phase.CLOSE) or state.mode in _RETURN_MODES
        elapsed_s = math.nan if self._start_s is None else state.time_s - self._start_s
        errors = [math.nan] * 4
        if elapsed_s >= 0 and state.mode in ("AUTO", "GUIDED"):
            path_error_m = self._path_error.update(np.array(place_m))
            errors = [path_error_m, *self._errors_at(elapsed_s, state)]
        speed_m_s = math.hypot(*state.velocity_m_s[:2])
        known_s = elapsed_s if elapsed_s >= 0 else math.nan
        return MapPoint(*place_m, state.alt_m, speed_m_s, returns, known_s, *errors)

    def _errors_at(self, elapsed_s: float, state: VehicleState) -> tuple[float, float, float]:
        """Position, height and heading error at ``elapsed_s``; NaN where unknown or outside the recording."""
        now = np.array([elapsed_s])
        if not 0 <= elapsed_s <= self._wanted.time_s[-1]:
            return math.nan, math.nan, math.nan
        apart_m = self._frame.to_metres(state.lat_deg, state.lon_deg) - self._wanted.places_at(now)[0]
        height_m = abs(state.alt_m - float(np.interp(elapsed_s, self._wanted.time_s, self._wanted.up_m)))
        flown_deg = math.nan if state.heading_deg is None else state.heading_deg
        off_deg = turn_deg(flown_deg, float(self._wanted.headings_at(now)[0]))
        return math.hypot(*apart_m.tolist()), height_m, abs(off_deg)


def _predicted_path_error(route: Route) -> tuple[Floats, Floats]:
    """Times (n,), and how far the model is from the recorded line then (n,), matched in order."""
    flight = route.predicted_flight
    if flight is None or not (flight.time_s >= 0).any():
        return np.zeros(0), np.zeros(0)
    flight = flight.select(flight.time_s >= 0)
    shown = flight.select(thin_indices(len(flight), _PREDICTED_POINTS))
    return shown.time_s, match_in_order(shown.north_east_m, route.wanted.north_east_m).distance_m


class LivePathError:
    """Distance of a moving vehicle from a path (n, 2).

    The path is searched near the vehicle's last place on it, so that a path that crosses itself is
    matched in order. The search goes back a little too: before a sharp turn, the leg after the turn
    may be the nearer one. It goes the farther ahead the farther the vehicle is from the path: it may
    have left a part of it out.
    """

    def __init__(self, path_m: Floats) -> None:
        self._path = path_m if len(path_m) > 1 else np.repeat(path_m, 2, axis=0)
        self._along_m = lengths_along_m(self._path)
        self._reached_m = 0.0
        self._last_m: Floats | None = None
        self._error_m = 0.0

    def update(self, position_m: Floats) -> float:
        """Distance of the next position, searched ahead by twice the distance moved since the last."""
        moved_m = 0.0 if self._last_m is None else float(np.linalg.norm(position_m - self._last_m))
        self._last_m = position_m
        first, last = self._window(2 * (moved_m + self._error_m))
        start, step = self._path[first:last], np.diff(self._path[first : last + 1], axis=0)
        share, distances = nearest_on_segments(position_m, start, step)
        nearest = int(distances.argmin())
        length_m = float(np.linalg.norm(step[nearest]))
        self._reached_m = float(self._along_m[first + nearest]) + float(share[nearest]) * length_m
        self._error_m = float(distances[nearest])
        return self._error_m

    def _window(self, ahead_m: float) -> tuple[int, int]:
        """First and last index of the points to search; at least one segment."""
        begin_m, end_m = self._reached_m - SEARCH_WINDOW_M, self._reached_m + ahead_m + SEARCH_WINDOW_M
        first = max(int(np.searchsorted(self._along_m, begin_m, "right")) - 1, 0)
        first = min(first, len(self._path) - 2)
        last = min(max(int(np.searchsorted(self._along_m, end_m)), first + 1), len(self._path) - 1)
        return first, last
