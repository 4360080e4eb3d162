"""A route while it is being fitted, in local metres, and the mission that it stands for."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flight_replay.geometry.arrays import Flags, Floats
from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.mission.items import (
    Home,
    Mission,
    MissionItem,
    change_climb_speed,
    change_speed,
    speed_from_the_start,
    waypoint,
)
from flight_replay.mission.path import Destination, Path, path_through
from flight_replay.planning.fit.climb_speeds import leg_climbs_m_s, steep_legs
from flight_replay.planning.fit.reference import DECIMALS
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.navigation.hermite import MAX_TANGENTS_PER_CHORD

_DEGREE_DECIMALS, _HEIGHT_DECIMALS = 7, 2
_SHAPING_PLACES = 2
"""How many places before and behind legs shape their curves."""


@dataclass(frozen=True, slots=True, eq=False)
class Draft:
    """n places with how each is flown to: columns of shape (n,), places (n, 3) north, east, up.

    ``hold_s`` are whole seconds of waiting; ``speed_m_s`` is the ground speed asked for on the way
    to each place, not a number where the one before goes on (at the first: the vehicle's own).

    Places are kept to ``DECIMALS``: what processors and libraries make of their last bits would grow, step by
    step of a search, to another route.
    """

    places_m: Floats
    spline: Flags
    hold_s: Floats
    speed_m_s: Floats

    def __post_init__(self) -> None:
        object.__setattr__(self, "places_m", self.places_m.round(DECIMALS))

    def __len__(self) -> int:
        return len(self.places_m)

    @property
    def halts(self) -> Flags:
        """Where the vehicle comes to rest: where it waits, and at the end."""
        halts = self.hold_s > 0
        halts[-1] = True
        return halts

    def mission(self, frame: LocalFrame | FlatFrame, limits: Limits) -> Mission:
        """The mission items for a vehicle of such limits, with home at the origin of ``frame``."""
        lat, lon = frame.to_degrees(self.places_m[:, :2])
        climbs_m_s, speeds_m_s = self.speed_changes(limits)
        items: list[MissionItem] = []
        for i in range(len(self)):
            if np.isfinite(climbs_m_s[i]):
                items.append(change_climb_speed(round(float(climbs_m_s[i]), 2)))
            speed_m_s = round(float(speeds_m_s[i]), 2)
            if np.isfinite(speed_m_s):
                items += speed_from_the_start(speed_m_s) if i == 0 else [change_speed(speed_m_s)]
            items.append(
                waypoint(
                    float(lat[i]),
                    float(lon[i]),
                    float(self.places_m[i, 2]),
                    hold_s=float(self.hold_s[i]),
                    spline=bool(self.spline[i]),
                )
            )
        return Mission(tuple(items), Home(frame.lat_deg, frame.lon_deg, 0.0))

    def climbs_m_s(self, limits: Limits) -> Floats:
        """The climb speed of the leg to each place (n,), see ``climb_speeds``."""
        asked_m_s = with_every_speed(replace(self, speed_m_s=np.append(np.nan, self.speed_m_s[1:]))).speed_m_s
        return leg_climbs_m_s(self.places_m, asked_m_s, limits)

    def speed_changes(self, limits: Limits) -> tuple[Floats, Floats]:
        """Climb speeds and ground speeds (n,) to ask for, not a number where the one before goes on.

        Firmware that knows no climb speeds takes them for ground speeds, so that those follow them.
        """
        climbs_m_s = self.climbs_m_s(limits)
        every_m_s = with_every_speed(self).speed_m_s
        return climbs_m_s, np.where(np.isfinite(climbs_m_s), every_m_s, self.speed_m_s)

    def as_items_hold_it(self, frame: FlatFrame) -> Draft:
        """The draft with its places at degrees to 1e-7 and heights in whole centimetres; itself if they are.

        So little counts: from rest to rest a leg of a centimetre takes a second, one of none no time at all,
        and a vehicle may be through the cusp of a spline seconds sooner for it.
        """
        places_m = self.places_m.copy()
        lat_deg, lon_deg = frame.to_degrees(places_m[:, :2])
        places_m[:, 2] = places_m[:, 2].round(_HEIGHT_DECIMALS)
        places_m[:, :2] = frame.to_metres(lat_deg.round(_DEGREE_DECIMALS), lon_deg.round(_DEGREE_DECIMALS))
        held = replace(self, places_m=places_m)
        return self if np.array_equal(held.places_m, self.places_m) else held

    def select(self, which: slice | Flags) -> Draft:
        """The places that a slice or a mask picks."""
        return Draft(self.places_m[which], self.spline[which], self.hold_s[which], self.speed_m_s[which])

    def part(self, first: int, end: int) -> Draft:
        """The places from ``first`` up to below ``end``."""
        return self.select(slice(first, end))

    def path(self, tolerance_m: float) -> Path:
        """The planned path; ``seq`` of its points is the index of the place that they lead to."""
        halts = self.halts
        return path_through(
            [
                Destination(i, place, bool(self.spline[i]), bool(halts[i]))
                for i, place in enumerate(self.places_m)
            ],
            tolerance_m=tolerance_m,
        )

    def legs_path(self, first: int, last: int, tolerance_m: float) -> Floats:
        """The planned line (k, 2) of the legs to places ``first`` to ``last``, from the place before on."""
        begin = max(first - 1 - _SHAPING_PLACES, 0)
        path = self.part(begin, last + 1 + _SHAPING_PLACES).path(tolerance_m)
        on_legs = (path.seq >= first - begin) & (path.seq <= last - begin)
        return np.asarray(path.north_east_m[on_legs | np.append(on_legs[1:], False)])


def flown_through(hold_s: Floats, *, timed: bool, straight_starts: bool) -> Flags:
    """To which places (n,) splines lead at first: where the time counts, to those that are flown through.

    A stop is reached straight then: what a spline's rounded numbers leave of its motion at a stop may
    hold the next leg up for seconds. With ``straight_starts`` it is left straight, too.
    """
    through = np.asarray((hold_s == 0) | (not timed))
    if straight_starts:
        through[1:] &= hold_s[:-1] == 0
    through[0] = False
    return through


def without_hooks(draft: Draft) -> Draft:
    """The draft with straight legs where splines from stops would begin backwards.

    From rest a curve sets out along 3 d - t, by the way d to its end and the tangent t there, of 4 d at most
    (SplineCurve::set_origin_and_destination). A real vehicle is through the hook that this makes at another
    time than the model says, up to half a second sooner, and so is all that follows.
    """
    places_m, spline = draft.places_m, draft.spline.copy()
    ways_m, through = np.diff(places_m, axis=0)[:-1], draft.hold_s[1:-1] == 0
    tangents_m = places_m[2:] - np.where(spline[2:, None], places_m[:-2], places_m[1:-1])
    squares = (ways_m**2).sum(axis=1)
    longest_m = MAX_TANGENTS_PER_CHORD * np.sqrt(squares)
    share = np.minimum(1.0, longest_m / np.maximum(np.linalg.norm(tangents_m, axis=1), 1e-9))
    backwards = share * (tangents_m * ways_m).sum(axis=1) > 3.0 * squares
    from_stop = np.append(True, draft.hold_s[1:] > 0)[: len(through)]
    spline[1:-1] &= ~(backwards & from_stop & through)
    return replace(draft, spline=spline)


def with_straight_climbs(draft: Draft) -> Draft:
    """The draft with straight steep legs, and straight to and from them but for stops; itself if it has such.

    Out of a curve from level flight to a steep descent a vehicle falls, and flies past it.
    """
    steep, through = steep_legs(draft.places_m), draft.hold_s == 0
    before, behind = np.append(steep[1:] & through[:-1], False), np.append(False, (steep & through)[:-1])
    spline = draft.spline & ~(steep | before | behind)
    return draft if np.array_equal(spline, draft.spline) else replace(draft, spline=spline)


def with_every_speed(draft: Draft) -> Draft:
    """The draft with the speed of each leg said, but for the first, also where it goes on as before."""
    speeds = draft.speed_m_s.copy()
    for place in range(2, len(speeds)):
        if np.isnan(speeds[place]):
            speeds[place] = speeds[place - 1]
    return replace(draft, speed_m_s=speeds)
