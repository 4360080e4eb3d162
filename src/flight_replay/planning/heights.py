"""Heights above home along a recording: those that are wanted, and those that the vehicle can keep."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.polyline import speeds_m_s
from flight_replay.logs.track import Track
from flight_replay.planning.altitude import FLOOR_M, RECORDED, Recorded, altitudes_m
from flight_replay.planning.climbs import feasible_heights_m
from flight_replay.simulator.dynamics.limits import Limits


@dataclass(frozen=True, slots=True, eq=False)
class Heights:
    """Metres above home at n fixes (n,).

    ``wanted_m`` are constant or recorded ones, none below the floor; the flown heights are compared with
    them. ``planned_m`` are those that the vehicle can reach in time, for a mission to ask for.
    """

    wanted_m: Floats
    planned_m: Floats

    def select(self, fixes: slice) -> Heights:
        """The heights of some of the fixes."""
        return Heights(self.wanted_m[fixes], self.planned_m[fixes])


@dataclass(frozen=True, slots=True)
class HeightChange:
    """How many fixes are not flown at their height, and by how much they are off at most."""

    fixes: int
    max_m: float


@dataclass(frozen=True, slots=True)
class RouteHeights:
    """What a route does with heights; metres above home.

    ``climb_s`` is how long AUTO takes to the first waypoint. ``floor_m`` is None where the
    altitude is constant; ``raised`` are the fixes that were recorded below it, ``limited`` those whose
    height the vehicle cannot have in time. ``notes`` are sentences for people.
    """

    takeoff_m: float
    first_m: float
    climb_s: float
    floor_m: float | None
    raised: HeightChange
    limited: HeightChange
    notes: tuple[str, ...]


def heights_of(
    track: Track,
    altitude_m: float | Recorded,
    floor_m: float = FLOOR_M,
    timed_limits: Limits | None = None,
    raise_m: float = 0.0,
) -> Heights:
    """The heights to fly at each fix of a track.

    Args:
        track: fixes of one vehicle.
        altitude_m: constant, or as recorded.
        floor_m: lower recorded heights are raised to this.
        timed_limits: what the vehicle may do, where the recorded times are to be kept. Without them it
            takes the time that a climb needs, and every height can be kept.
        raise_m: recorded heights are raised by so much.
    """
    wanted_m = altitudes_m(track, altitude_m, floor_m, raise_m)
    if timed_limits is None or altitude_m != RECORDED or not len(track):
        return Heights(wanted_m, wanted_m)
    time_s = np.maximum.accumulate(track.time_s)
    speed_m_s = speeds_m_s(time_s, track.north_east_m(track.frame))
    return Heights(wanted_m, feasible_heights_m(time_s, wanted_m, speed_m_s, timed_limits, floor_m))
