"""A speed that is asked for but that the vehicle does not reach: said before it flies."""

from __future__ import annotations

from math import degrees, tan

import numpy as np

from flight_replay.geometry.movement import Movement
from flight_replay.geometry.polyline import speeds_m_s
from flight_replay.planning.drag import sitl_drag
from flight_replay.planning.route import Route
from flight_replay.simulator.dynamics.limits import GRAVITY_M_S2

_REACHED = 0.95
"""Of the speed that is asked for; the vehicle is at it only for a moment where legs are short."""
_LEANS_ALL = 0.9
"""Of the speed at which drag takes the greatest lean, as the rotors lose some thrust in the air they meet."""
_WORTH_TELLING_S, _WORTH_TELLING_SHARE = 5.0, 0.1
"""A flight that takes longer by no more than this, or this share, is about as fast as the recorded one."""


def with_speed_note(route: Route, asked_m_s: float) -> Route:
    """The route with a sentence on a speed that its predicted flight does not reach.

    Args:
        route: of a mission; without a predicted flight it stays as it is.
        asked_m_s: ground speed that its mission asks for.
    """
    if route.predicted_flight is None:
        return route
    top_m_s = _top_speed_m_s(route.predicted_flight)
    if top_m_s >= _REACHED * asked_m_s:
        return route
    amsl_m, lean_rad = route.mission.home_item.alt_m, route.limits.limits.lean_angle_rad
    if _drag_m_s2(top_m_s / _LEANS_ALL, amsl_m) >= GRAVITY_M_S2 * tan(lean_rad):
        why = (
            f"at its greatest lean, {degrees(lean_rad):.0f} degrees, drag as of SITL's "
            "quadcopter lets it fly no faster"
        )
    else:
        why = "its legs are too short, and its turns too sharp, for more"
    return route.with_notes(
        f"The vehicle is expected to fly at up to {top_m_s:.1f} m/s, not at {asked_m_s:g} m/s: {why}."
    )


def with_recorded_speed_note(route: Route) -> Route:
    """The route with a sentence on a predicted flight that takes longer than the recorded one."""
    if route.predicted_flight is None:
        return route
    recorded_s = float(route.wanted.time_s[-1] - route.wanted.time_s[0])
    flown_s = float(route.predicted_flight.time_s[-1])
    if flown_s - recorded_s <= max(_WORTH_TELLING_S, _WORTH_TELLING_SHARE * recorded_s):
        return route
    note = (
        f"The vehicle is expected to take {flown_s:.0f} s for what was recorded in {recorded_s:.0f} s: its "
        "legs are too short, or its limits too low, for the recorded speed; --route fit keeps up better."
    )
    return route.with_notes(note)


def _top_speed_m_s(flown: Movement) -> float:
    return float(speeds_m_s(flown.time_s, flown.north_east_m).max(initial=0.0))


def _drag_m_s2(speed_m_s: float, amsl_m: float) -> float:
    """Deceleration by the air at a speed."""
    return float(sitl_drag(amsl_m).acceleration_m_s2(np.array([[speed_m_s, 0.0]]))[0, 0])
