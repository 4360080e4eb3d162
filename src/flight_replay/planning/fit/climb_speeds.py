"""How fast a draft's legs climb and descend where the recorded speed is kept.

A leg that leads more up or down than ahead is hardly slowed down by the ground speed asked for: a vehicle
would climb at ``WPNAV_SPEED_UP`` where the recorded one climbed slowly, along a facade or a mast, and wait
above for it. So the speed of such a leg is its climb or descent speed, too; on all others the vehicle's own
are in force.
"""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Flags, Floats
from flight_replay.simulator.dynamics.limits import Limits


def steep_legs(places_m: Floats) -> Flags:
    """Whether the legs to places (n, 3) lead more up or down than ahead (n,); that to the first does not."""
    steps_m = np.diff(places_m, axis=0)
    steep = np.abs(steps_m[:, 2]) > np.hypot(steps_m[:, 0], steps_m[:, 1])
    return np.append(False, steep)


def leg_climbs_m_s(places_m: Floats, speed_m_s: Floats, limits: Limits) -> Floats:
    """The climb speeds to ask for on the legs to places (n,), below 0 for a descent; not a number for none.

    One is asked for on each steep leg, and the vehicle's own on the next leg that leads the same way and is
    not steep. Asking for what is in force would not be nothing: the ground speed behind it comes later.

    Args:
        places_m: n places, north, east, up.
        speed_m_s: the speed of each leg (n,), not a number where none is asked for.
        limits: how fast the vehicle climbs and descends at most.
    """
    up_m = np.diff(places_m[:, 2], prepend=places_m[:1, 2])
    own_m_s = np.where(up_m > 0, limits.wp_speed_up_m_s, limits.wp_speed_down_m_s)
    steep = steep_legs(places_m) & np.isfinite(speed_m_s)
    asked, slowed = steep.copy(), {True: False, False: False}
    for place in np.flatnonzero(up_m).tolist():
        rises = bool(up_m[place] > 0)
        asked[place] |= slowed[rises]
        slowed[rises] = bool(steep[place])
    climb_m_s = np.where(steep, np.fmin(speed_m_s, own_m_s), own_m_s)
    return np.where(asked, np.copysign(climb_m_s, up_m), np.nan)
