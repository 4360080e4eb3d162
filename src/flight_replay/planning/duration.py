"""How long a vehicle flies a mission."""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.polyline import segment_lengths_m
from flight_replay.mission.items import FIRST_SEQ, Command, Mission
from flight_replay.mission.path import Path
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.navigation.leg_durations import straight_duration_s

_STEP_S = 0.1
"""Steps of the flight model that are good enough for a duration: 0.2 % off on 3 m legs."""
_SHORT_LEG_M = 6.0
"""Straight legs up to this are flown so slowly that the vehicle is where its target is: 0.5 % off."""
LONGEST_SIMULATED_M = 50_000.0
"""Longer routes are beyond any copter: their duration is that of their length at the speeds asked for."""


def duration_s(mission: Mission, path: Path, limits: Limits) -> float:
    """Seconds in AUTO that a vehicle takes for a mission, from above home; roughly, if that is for hours.

    Args:
        mission: at least one waypoint.
        path: the path of the mission.
        limits: what the vehicle may do.
    """
    if path.length_m > LONGEST_SIMULATED_M:
        return _at_the_speeds_asked_for_s(mission, path, limits)
    if _is_straight(mission) and segment_lengths_m(path.north_east_m).max(initial=0.0) <= _SHORT_LEG_M:
        corners = np.column_stack([path.north_east_m, path.up_m]).tolist()
        return straight_duration_s([(north, east, up) for north, east, up in corners], limits)
    # The model of the whole vehicle takes as long to import and run as all else in a dry run.
    from flight_replay.simulator.flight.trajectory import EndlessMissionError, simulate

    try:
        begin_s, end_s = simulate(mission, limits, step_s=_STEP_S).auto_s
    except EndlessMissionError:
        return _at_the_speeds_asked_for_s(mission, path, limits)
    return end_s - begin_s


def _at_the_speeds_asked_for_s(mission: Mission, path: Path, limits: Limits) -> float:
    """What a mission takes that is flown at once at the speed that is in force, and waits."""
    items = len(mission.items)
    leg_m = np.bincount(path.seq[1:] - FIRST_SEQ, segment_lengths_m(path.north_east_m), minlength=items)
    speed_m_s, total_s = limits.wp_speed_m_s, 0.0
    for item, length_m in zip(mission.items, leg_m.tolist(), strict=True):
        speed_m_s = item.ground_speed_m_s or speed_m_s
        total_s += length_m / speed_m_s + item.hold_s
    return total_s


def _is_straight(mission: Mission) -> bool:
    """Whether a mission is of straight legs alone, without holds."""
    return all(item.command == Command.WAYPOINT and not item.hold_s for item in mission.items)
