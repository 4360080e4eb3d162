"""What the live map shows, gathered from events as they come; knows neither server nor page.

While a flight goes on, nobody can tell yet which flown place a recorded fix will be nearest to. So
the live distance in space is that of the flown position from the recorded path, followed forwards;
the distance in time is DESIGN.md's own. The report has the final figures.
"""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass

import numpy as np

from flight_replay.events import Event, VehicleState, WaypointReached
from flight_replay.geometry.arrays import Floats
from flight_replay.output.replay_status import Status
from flight_replay.planning.route import Route

LOOK_AROUND_M = 15.0
"""How far along the recorded path, back and beyond what it flew, the vehicle is looked for."""


@dataclass(frozen=True, slots=True)
class Point:
    """One position of the vehicle: metres from the first fix, and its distances, not a number if unknown.

    ``elapsed_s`` counts from the reaching of the first waypoint.
    """

    north_m: float
    east_m: float
    elapsed_s: float
    in_space_m: float
    in_time_m: float


class LiveData:
    """A listener that turns positions into points of the map; safe to read from other threads."""

    def __init__(self, route: Route) -> None:
        covered = route.covered
        self._frame = covered.frame
        self._recorded_s = covered.time_s - covered.time_s[0]
        self._recorded_m = covered.north_east_m(self._frame)
        self._follower = Follower(self._recorded_m)
        self._first_seq = route.mission.waypoints[0][0]
        self._places = {seq: (item.lat_deg, item.lon_deg) for seq, item in route.mission.waypoints}
        self._begun_s: float | None = None
        self._points: list[Point] = []
        self._lock = threading.Lock()
        self.status = Status()

    def listener(self, event: Event) -> None:
        """Take an event in."""
        self.status.update(event)
        if isinstance(event, WaypointReached) and event.seq == self._first_seq and self._begun_s is None:
            self._begun_s = event.time_s
        if isinstance(event, VehicleState):
            point = self._point(event)
            with self._lock:
                self._points.append(point)

    def points(self, since: int) -> list[Point]:
        """The points from number ``since`` on."""
        with self._lock:
            return self._points[since:]

    def target_m(self) -> tuple[float, float] | None:
        """North and east of the waypoint that the vehicle flies to; None when it flies to none."""
        heading = self.status.heading
        place = self._places.get(heading.seq) if heading is not None and self.status.ended is None else None
        if place is None:
            return None
        north_m, east_m = self._frame.to_metres(*place)
        return float(north_m), float(east_m)

    def _point(self, state: VehicleState) -> Point:
        here = self._frame.to_metres(state.lat_deg, state.lon_deg)
        north_m, east_m = float(here[0]), float(here[1])
        if self._begun_s is None or state.mode != "AUTO":
            return Point(north_m, east_m, math.nan, math.nan, math.nan)
        elapsed_s = state.time_s - self._begun_s
        return Point(
            north_m, east_m, elapsed_s, self._follower.distance_m(here), self._late_m(elapsed_s, here)
        )

    def _late_m(self, elapsed_s: float, here: Floats) -> float:
        """Distance from where the recorded vehicle was as long after its start, while it was recorded."""
        if not 0 <= elapsed_s <= self._recorded_s[-1]:
            return math.nan
        there = [float(np.interp(elapsed_s, self._recorded_s, self._recorded_m[:, axis])) for axis in (0, 1)]
        return math.hypot(here[0] - there[0], here[1] - there[1])


class Follower:
    """Distances of a moving point from a path (n, 2), looked for near where it was last: never borrowed.

    A little way back counts too: before a sharp turn, the way out of it may be the nearer one.
    """

    def __init__(self, path_m: Floats) -> None:
        self._path = path_m if len(path_m) > 1 else np.repeat(path_m, 2, axis=0)
        steps_m = np.linalg.norm(np.diff(self._path, axis=0), axis=1)
        self._along_m = np.append(0.0, np.cumsum(steps_m))
        self._reached_m = 0.0
        self._before: Floats | None = None

    def distance_m(self, here: Floats) -> float:
        """Distance of the next position; looks ahead by twice the way that was made since the last."""
        made_m = 0.0 if self._before is None else float(np.linalg.norm(here - self._before))
        self._before = here
        first, last = self._window(2 * made_m)
        start, step = self._path[first:last], np.diff(self._path[first : last + 1], axis=0)
        squared = (step**2).sum(axis=1)
        share = ((here - start) * step).sum(axis=1) / np.where(squared > 0, squared, 1.0)
        share = np.clip(share, 0.0, 1.0)
        distances = np.linalg.norm(start + share[:, None] * step - here, axis=1)
        nearest = int(distances.argmin())
        self._reached_m = float(self._along_m[first + nearest] + share[nearest] * math.sqrt(squared[nearest]))
        return float(distances[nearest])

    def _window(self, ahead_m: float) -> tuple[int, int]:
        """First and last point of the pieces to look at; at least one piece."""
        begin_m, end_m = self._reached_m - LOOK_AROUND_M, self._reached_m + ahead_m + LOOK_AROUND_M
        first = max(int(np.searchsorted(self._along_m, begin_m, "right")) - 1, 0)
        first = min(first, len(self._path) - 2)
        last = min(max(int(np.searchsorted(self._along_m, end_m)), first + 1), len(self._path) - 1)
        return first, last
