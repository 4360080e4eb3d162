"""What a fit follows: fixes as local metres, and where in them the vehicle hovered."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.geometry.polyline import nearest_on_line_m, speeds_m_s
from flight_replay.logs.track import Track
from flight_replay.planning.altitude import home_of

HOVER_RADIUS_M = 0.3
"""A vehicle that hovers wanders about as far in some seconds; farther, it was on its way."""
SHORTEST_HOVER_S = 5.0
"""Shorter pauses are flown slowly: to brake, wait and start again takes ArduCopter as long."""
ROOMY_HOVER_S = 3.5
"""Where legs are long anyway, so much is worth a stop: one speed a leg would smear it over all of a leg."""
LEAST_HOLD_S = 1.0
"""Items wait whole seconds."""
SETTLE_HOLD_S, TIMED_SETTLE_HOLD_S = 1.0, 6.0
"""At the first place a vehicle comes to rest before what is timed begins. On the way there its target hardly
moves, and the noise of the estimated velocity slows it down (_track_scalar_dt), which takes seconds to wear
off: after 1 s real first legs came up to 0.6 s late, and all else with them, after 6 s give or take 0.1 s."""

DECIMALS = 6
"""Metres and seconds are kept to so many decimals where a search would go on with their last bits."""
_MOST_CORNERS, _PLACES_AT_ONCE = 4000, 8
"""How many distances are found at once: more leave the cache, and would take much memory."""


@dataclass(frozen=True, slots=True)
class Takeoff:
    """Where the vehicle takes off: ``amsl_m`` above the sea, as thin air holds it back less, to ``up_m``.

    ``up_m`` is above home; None is the height at which the recording begins.
    """

    amsl_m: float
    up_m: float | None = None


AT_SEA_LEVEL = Takeoff(0.0)


@dataclass(frozen=True, slots=True, eq=False)
class LocalTrack:
    """What is to be followed: n fixes in local metres (n, 2), heights and seconds from the first (n,).

    ``takeoff`` is where the vehicle that follows it comes from.
    """

    time_s: Floats
    north_east_m: Floats
    up_m: Floats
    takeoff: Takeoff = AT_SEA_LEVEL

    def __len__(self) -> int:
        return len(self.time_s)

    def thinned(self, most: int) -> LocalTrack:
        """At most ``most`` of the fixes, evenly spread, both ends included."""
        keep = np.unique(np.linspace(0, len(self) - 1, min(len(self), most)).round().astype(np.intp))
        return LocalTrack(self.time_s[keep], self.north_east_m[keep], self.up_m[keep], self.takeoff)

    def nearest_m(self, places_m: Floats) -> Floats:
        """The points (m, 2) of the line through the fixes that are nearest to places (m, 2)."""
        if len(self) == 1:
            return np.repeat(self.north_east_m, len(places_m), axis=0)
        corners = self.thinned(_MOST_CORNERS).north_east_m
        parts = range(0, len(places_m), _PLACES_AT_ONCE)
        return np.vstack([nearest_on_line_m(places_m[i : i + _PLACES_AT_ONCE], corners) for i in parts])

    @property
    def axes(self) -> int:
        """In how many axes of space fixes are told apart: two where all are at one height, else three."""
        return 3 if np.ptp(self.up_m) > 0 else 2

    @property
    def north_east_up_m(self) -> Floats:
        """The fixes (n, 3)."""
        return np.column_stack([self.north_east_m, self.up_m])

    @property
    def places_m(self) -> Floats:
        """The fixes (n, axes): north, east, and up where that changes."""
        return self.north_east_up_m[:, : self.axes]

    @property
    def speed_m_s(self) -> Floats:
        """Ground speed at every fix, from the places alone."""
        return speeds_m_s(self.time_s, self.north_east_m)

    @property
    def fastest_m_s(self) -> Floats:
        """Ground speed at every fix, or how fast it climbs or descends there, if that is faster."""
        if self.axes == 2:
            return self.speed_m_s
        return np.maximum(self.speed_m_s, speeds_m_s(self.time_s, self.up_m[:, None]))


@dataclass(frozen=True, slots=True)
class Hover:
    """Fixes ``first`` to ``last``, both included, at one place; ``seconds`` in all."""

    first: int
    last: int
    seconds: float


def hovers(recording: LocalTrack, most: int, shortest_s: float = SHORTEST_HOVER_S) -> list[Hover]:
    """The ``most`` longest hovers, in order: stretches that fit into ``HOVER_RADIUS_M``, heights too."""
    places = recording.north_east_up_m.tolist()
    times = recording.time_s.tolist()
    found, i = [], 0
    while i < len(times):
        end = _hover_end(places, i)
        seconds = times[end - 1] - times[i]
        if seconds >= shortest_s:
            found.append(Hover(i, end - 1, seconds))
            i = end
        else:
            i += 1
    longest = sorted(found, key=lambda hover: -hover.seconds)[:most]
    return sorted(longest, key=lambda hover: hover.first)


def holds_s(places: int, hovers: Mapping[int, Hover], *, timed: bool) -> Floats:
    """How long to wait at each of so many places (n,), whole seconds: at the first, and where it hovers."""
    hold_s = np.zeros(places)
    hold_s[0] = TIMED_SETTLE_HOLD_S if timed else SETTLE_HOLD_S
    for place, hover in hovers.items():
        hold_s[place] = max(LEAST_HOLD_S, round(hover.seconds))
    return hold_s


def _hover_end(places: list[list[float]], begin: int) -> int:
    """Index of the first place from ``begin`` on that no longer fits into the circle with those before."""
    low, high = list(places[begin]), list(places[begin])
    for i in range(begin + 1, len(places)):
        for axis, value in enumerate(places[i]):
            low[axis] = min(low[axis], value)
            high[axis] = max(high[axis], value)
        if sum((b - a) ** 2 for a, b in zip(low, high, strict=True)) > (2 * HOVER_RADIUS_M) ** 2:
            return i
    return len(places)


def flat_frame(track: Track) -> FlatFrame:
    """ArduPilot's frame around the track's first fix."""
    return FlatFrame(float(track.lat_deg[0]), float(track.lon_deg[0]))


def local_track(track: Track, height_m: float | Floats, takeoff_m: float | None = None) -> LocalTrack:
    """What the fit follows, in ArduPilot's own metres around the track's first fix.

    The vehicle navigates in those: in ground metres, up to 0.5 % different, its time would be too.

    Args:
        track: at least one fix.
        height_m: height above home to fly at, one for all fixes or one for each (n,).
        takeoff_m: height above home that the vehicle takes off to; None: where it begins.
    """
    times = track.time_s - track.time_s[0]
    heights = np.broadcast_to(np.asarray(height_m, float), len(track))
    places = flat_frame(track).to_metres(track.lat_deg, track.lon_deg)
    times, places, heights = (column.round(DECIMALS) for column in (times, places, heights))
    return LocalTrack(times, places, heights, Takeoff(home_of(track).alt_amsl_m or 0.0, takeoff_m))
