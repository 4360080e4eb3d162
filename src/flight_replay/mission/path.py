"""The path that a mission draws on the ground: straight legs as lines, spline legs as ArduCopter's curves.

Metres in a local frame, north and east; altitudes are metres above home. This is the line on paper,
without the vehicle's dynamics: ``simulator`` knows how it is flown.

The curve of a spline leg is the cubic Hermite curve of ArduCopter's ``SplineCurve.cpp`` between
its origin and destination, with the tangents of ``AC_WPNav::set_spline_destination`` (4.0 to 4.7):

- at the destination: next destination minus origin if the next leg is a spline too, next destination
  minus destination if it is straight, zero if there is none or if the vehicle halts there;
- at the origin: the previous spline leg's tangent at its destination, or the vector of the previous
  straight leg, or zero where the vehicle halted;
- both are scaled down when together they are longer than four times the leg.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flight_replay.geometry.arrays import Flags, Floats, Indices
from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.geometry.hermite_curve import curve_weights, steps_within, tangent_scale
from flight_replay.geometry.polyline import segment_lengths_m
from flight_replay.mission.items import FIRST_SEQ, WAIT_HERE, WAYPOINT_COMMANDS, Command, Mission, MissionItem

TOLERANCE_M = 0.001
"""How far the lines that stand for a curve may lie from it."""
# MAV_CMD numbers below this navigate; a mission goes through them one after the other.
_FIRST_CONDITION = 95
_FLOWN_INTO = WAYPOINT_COMMANDS | {Command.LOITER_UNLIMITED, Command.LOITER_TIME}
_HALTED_AT = frozenset({Command.LOITER_TURNS, Command.LAND})


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """A line through m points: where each is, and which mission item the line up to there leads to.

    ``north_east_m`` (m, 2); ``up_m`` (m,); ``seq`` (m,) the items' sequence numbers.
    """

    north_east_m: Floats
    up_m: Floats
    seq: Indices

    @property
    def length_m(self) -> float:
        """Ground length, metres."""
        return float(segment_lengths_m(self.north_east_m).sum())


@dataclass(frozen=True, slots=True, eq=False)
class Destination:
    """Where a leg ends, in local metres (north, east, up).

    ``spline`` is whether the leg is a curve, ``halts`` whether the vehicle comes to rest at its end.
    """

    seq: int
    position_m: Floats
    spline: bool = False
    halts: bool = False


def planned_path(mission: Mission, frame: LocalFrame) -> Path:
    """The path of a mission in ``frame`` from its first destination; an empty path without one."""
    return path_through(destinations(mission.items, frame))


def destinations(items: Sequence[MissionItem], frame: LocalFrame) -> list[Destination]:
    """Where the items lead, as ArduCopter reads zeros: coordinates 0, 0 are here, altitude 0 stays the same.

    The wait that a mission may begin with leads nowhere: where the vehicle comes from is not known.

    Before anything but a waypoint or a plain loiter, the vehicle halts (``ModeAuto::set_next_wp``).
    """
    found: list[Destination] = []
    here = np.zeros(3)
    for seq, item in enumerate(items, FIRST_SEQ):
        if item.command >= _FIRST_CONDITION:
            continue
        if item.command not in _FLOWN_INTO and found:
            found[-1] = replace(found[-1], halts=True)
        if not found and item == WAIT_HERE:
            continue
        if item.command in _FLOWN_INTO or item.command in _HALTED_AT:
            here = _position_m(item, frame, here)
            halts = item.hold_s > 0 or not item.is_waypoint
            found.append(Destination(seq, here, item.is_spline, halts))
    return found


def _position_m(item: MissionItem, frame: LocalFrame, here_m: Floats) -> Floats:
    """Where an item is (3,), coming from ``here_m``."""
    position = np.array(here_m)
    if item.lat_deg != 0 or item.lon_deg != 0:
        position[:2] = frame.to_metres(item.lat_deg, item.lon_deg)
    if item.alt_m != 0 and item.command != Command.LAND:
        position[2] = item.alt_m
    return position


def path_through(route: Sequence[Destination], tolerance_m: float = TOLERANCE_M) -> Path:
    """The path along ``route``; its curves are drawn as lines that stay within ``tolerance_m``."""
    if not route:
        return Path(np.zeros((0, 2)), np.zeros(0), np.zeros(0, np.intp))
    positions = [destination.position_m for destination in route]
    corners = np.array([positions[0], *positions])
    spline = np.array([destination.spline for destination in route])
    chord, (leaving, arriving) = np.diff(corners, axis=0), leg_tangents(route, corners)
    steps = np.where(spline, steps_within(chord, leaving, arriving, tolerance_m), 1)
    ends = np.cumsum(steps)
    leg = np.repeat(np.arange(len(route)), steps)
    t = (np.arange(len(leg)) - (ends - steps)[leg] + 1) / steps[leg]
    curves = np.stack([corners[:-1], corners[1:], leaving, arriving], axis=1)
    line = np.concatenate([corners[:1], np.einsum("nk,nkd->nd", curve_weights(t), curves[leg])])
    line[ends] = corners[1:]
    seq = np.array([destination.seq for destination in route])
    return Path(line[:, :2], line[:, 2], np.append(seq[0], seq[leg]).astype(np.intp))


def leg_tangents(route: Sequence[Destination], corners_m: Floats) -> tuple[Floats, Floats]:
    """Tangents (n, 3) of n legs at their origins and at their destinations, scaled down where too long.

    Args:
        route: what each leg leads to.
        corners_m: where the route begins, and its n destinations (n + 1, 3).
    """
    chord = np.diff(corners_m, axis=0)
    ends = tangent_ends(
        np.array([destination.spline for destination in route]),
        np.array([destination.halts for destination in route]),
        np.logical_not(chord.any(axis=1)),
    )
    leaving, arriving = (corners_m[head] - corners_m[tail] for head, tail in ends)
    scale = tangent_scale(chord, leaving, arriving)[:, None]
    return scale * leaving, scale * arriving


def tangent_ends(
    spline: Flags, halts: Flags, empty: Flags
) -> tuple[tuple[Indices, Indices], tuple[Indices, Indices]]:
    """The corners (head, tail), each (n,), whose differences are the tangents of n legs, see the module.

    First those at the legs' origins, then those at their destinations. Leg k leads from corner k to
    corner k + 1; a tangent of zero has head and tail alike.

    Args:
        spline: which legs are curves.
        halts: at whose destination the vehicle comes to rest; at the last it always does.
        empty: which legs have no length.
    """
    leg = np.arange(len(spline))
    rests = halts | (spline & empty) | (leg == leg[-1])
    before_spline = np.append(spline[1:], False)
    head = np.where(rests, 0, np.where(spline, leg + 2, leg + 1))
    tail = np.where(rests, 0, np.where(spline & ~before_spline, leg + 1, leg))
    return (np.append(0, head[:-1]), np.append(0, tail[:-1])), (head, tail)
