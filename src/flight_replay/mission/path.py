"""The path that a mission draws on the ground: straight legs as lines, spline legs as ArduCopter's curves.

Metres in a local frame; columns are north and east, heights are metres above home. This is the
line on paper, without the vehicle's dynamics: ``simulator`` knows how it is flown.

The curve of a spline leg is the cubic Hermite curve of ArduCopter's ``SplineCurve.cpp`` between
its origin and destination, with the tangents of ``AC_WPNav::set_spline_destination`` (4.0 to 4.7):

- leaving the destination: next place minus origin if the next leg is a spline too, next place minus
  destination if it is straight, zero if there is none or if the vehicle holds there;
- leaving the origin: the previous spline leg's destination tangent, or the vector of the previous
  straight leg, or zero where the vehicle stood still;
- both are scaled down when together they are longer than four times the leg.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.mission.items import FIRST_SEQ, WAYPOINT_COMMANDS, Command, Mission, MissionItem

TANGENT_PER_CHORD = 4.0
"""Longest sum of both tangents, in lengths of the leg (SPLINE_FACTOR)."""
TOLERANCE_M = 0.001
"""How far the lines that stand for a curve may lie from it."""
# MAV_CMD numbers below this navigate; a mission goes through them one after the other.
_FIRST_CONDITION = 95
_FLOWN_INTO = WAYPOINT_COMMANDS | {Command.LOITER_UNLIMITED, Command.LOITER_TIME}
_HALTED_AT = frozenset({Command.LOITER_TURNS, Command.LAND})


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """A line through m points: where each is, and which mission item the piece ending there leads to.

    ``north_east_m`` (m, 2); ``up_m`` (m,); ``seq`` (m,) sequence numbers; ``hold_s`` (m,) is not
    zero at the points where the vehicle waits.
    """

    north_east_m: Floats
    up_m: Floats
    seq: NDArray[np.intp]
    hold_s: Floats

    @property
    def length_m(self) -> float:
        """Ground length, metres."""
        return float(np.linalg.norm(np.diff(self.north_east_m, axis=0), axis=1).sum())


@dataclass(frozen=True, slots=True, eq=False)
class Destination:
    """A place to fly to, in local metres (north, east, up): what a leg ends at.

    ``halts`` says that the vehicle comes to rest there, be it to wait ``hold_s`` seconds.
    """

    seq: int
    position_m: Floats
    spline: bool = False
    hold_s: float = 0.0
    halts: bool = False


def planned_path(
    mission: Mission | Sequence[MissionItem], frame: LocalFrame, start_m: ArrayLike | None = None
) -> Path:
    """The path of a mission in ``frame``, from ``start_m`` (north, east, up), or else from its first place.

    A mission without a place gives the start alone, or an empty path.
    """
    items = mission.items if isinstance(mission, Mission) else tuple(mission)
    start = None if start_m is None else np.asarray(start_m, float)
    return path_through(destinations(items, frame, start), start)


def destinations(
    items: Sequence[MissionItem], frame: LocalFrame, start_m: Floats | None = None
) -> list[Destination]:
    """The places of the items, with ArduCopter's reading of zeros: 0,0 is here, height 0 keeps the height.

    Before anything but a waypoint or a plain loiter, the vehicle halts (``ModeAuto::set_next_wp``).
    """
    found: list[Destination] = []
    here = np.zeros(3) if start_m is None else start_m
    for seq, item in enumerate(items, FIRST_SEQ):
        if item.command >= _FIRST_CONDITION:
            continue
        if item.command not in _FLOWN_INTO and found:
            found[-1] = replace(found[-1], halts=True)
        if item.command in _FLOWN_INTO or item.command in _HALTED_AT:
            here = _place(item, frame, here)
            found.append(
                Destination(seq, here, item.is_spline, item.hold_s, item.hold_s > 0 or not item.is_waypoint)
            )
    return found


def _place(item: MissionItem, frame: LocalFrame, here: Floats) -> Floats:
    """Where an item is, coming from ``here``."""
    place = np.array(here)
    if item.lat_deg != 0 or item.lon_deg != 0:
        place[:2] = frame.to_metres(item.lat_deg, item.lon_deg)
    if item.alt_m != 0 and item.command != Command.LAND:
        place[2] = item.alt_m
    return place


def path_through(
    route: Sequence[Destination], start_m: Floats | None = None, tolerance_m: float = TOLERANCE_M
) -> Path:
    """The path along ``route``; its curves are drawn as lines that stay within ``tolerance_m``."""
    if not route:
        alone = np.zeros((0, 3)) if start_m is None else start_m[None]
        return Path(alone[:, :2], alone[:, 2], np.full(len(alone), FIRST_SEQ, np.intp), np.zeros(len(alone)))
    places = [stop.position_m for stop in route]
    first = places[0] if start_m is None else start_m
    points, seqs, holds = [first[None]], [np.array([route[0].seq])], [np.zeros(1)]
    origins = [first, *places[:-1]]
    tangents = leg_tangents(route, first)
    for stop, origin, (leaving, arriving) in zip(route, origins, tangents, strict=True):
        leg = stop.position_m[None]
        if stop.spline:
            leg = hermite(origin, stop.position_m, leaving, arriving, tolerance_m)[1:]
        points.append(leg)
        seqs.append(np.full(len(leg), stop.seq))
        holds.append(np.append(np.zeros(len(leg) - 1), stop.hold_s))
    line = np.concatenate(points)
    return Path(line[:, :2], line[:, 2], np.concatenate(seqs).astype(np.intp), np.concatenate(holds))


def leg_tangents(route: Sequence[Destination], first_m: Floats) -> list[tuple[Floats, Floats]]:
    """Unscaled tangents (at the origin, at the destination) of every leg; on straight legs, their vector."""
    tangents: list[tuple[Floats, Floats]] = []
    origin, leaving = first_m, np.zeros(3)
    for here, following in zip(route, [*route[1:], None], strict=True):
        arriving = here.position_m - origin
        if following is None or here.halts or (here.spline and not arriving.any()):
            arriving = np.zeros(3)
        elif here.spline:
            arriving = following.position_m - (origin if following.spline else here.position_m)
        tangents.append((leaving, arriving))
        origin, leaving = here.position_m, arriving
    return tangents


def hermite(
    origin_m: Floats,
    destination_m: Floats,
    leaving: Floats,
    arriving: Floats,
    tolerance_m: float = TOLERANCE_M,
) -> Floats:
    """Points (n, 3) of ArduCopter's curve between two places, both ends included."""
    together = np.linalg.norm(leaving) + np.linalg.norm(arriving)
    longest = TANGENT_PER_CHORD * np.linalg.norm(destination_m - origin_m)
    scale = longest / together if together > longest else 1.0
    v0, v1, chord = leaving * scale, arriving * scale, destination_m - origin_m
    square, cube = 3 * chord - 2 * v0 - v1, v0 + v1 - 2 * chord
    bend = max(np.linalg.norm(2 * square), np.linalg.norm(2 * square + 6 * cube))
    pieces = max(1, int(np.ceil(np.sqrt(bend / (8 * tolerance_m)))))
    u = np.linspace(0, 1, pieces + 1)[:, None]
    return np.asarray(origin_m + u * (v0 + u * (square + u * cube)))
