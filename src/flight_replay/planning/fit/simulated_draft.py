"""A draft flown in the model of ArduCopter."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import isfinite

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.mission.items import FIRST_SEQ, Command, change_climb_speed, change_speed
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.reference import AT_SEA_LEVEL, Takeoff
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.flight.copter import Copter
from flight_replay.simulator.flight.flown_positions import AXES, positions_to_end
from flight_replay.simulator.mission.local_items import LocalItem

_LAST_PART_M = 2.0
_LEAST_UP_SHARE = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedDraft:
    """Where the vehicle was: times (k,) from reaching the first place, places (k, 3) north, east, up.

    ``passed_s`` (n,) is when each of the draft's n places was reached, those after an end on the ground at
    the end. ``stays_up`` says whether there was no such end, and the vehicle nowhere below half of the
    height of the lowest place: a fast one may fall out of the curves of a spline that dives. ``has_error``
    says whether ArduPilot reports an internal error on a leg.
    """

    draft: Draft
    time_s: Floats
    place_m: Floats
    passed_s: Floats
    stays_up: bool = True
    has_error: bool = False


def simulate_draft(
    draft: Draft, limits: Limits, step_s: float, takeoff: Takeoff = AT_SEA_LEVEL
) -> SimulatedDraft:
    """Fly a draft that begins above where the vehicle takes off.

    Args:
        draft: at least one place.
        limits: what the vehicle may do.
        step_s: duration of the model's steps.
        takeoff: where the vehicle comes from.

    Raises:
        MissionError: the vehicle neither reaches the last place nor the ground.
    """
    items, seqs = items_of(draft, limits)
    copter = copter_after_takeoff(draft, limits, step_s, takeoff)
    copter.start_auto(items)
    positions = [*copter.position_m, *positions_to_end(copter)]
    return flight_of(draft, copter, seqs, positions)


def flight_of(draft: Draft, copter: Copter, seqs: list[int], positions: list[float]) -> SimulatedDraft:
    """A draft as a copter has flown it to the end, with the positions before and after each step."""
    run, step_s = copter.mission, copter.step_s
    assert run is not None, "a draft is flown in AUTO"
    place_m = places_of(positions)
    end_s = step_s * (len(place_m) - 1)
    passed_s = np.array([_reached_s(run.reached, seq, end_s) for seq in seqs])
    place_m = place_m[round(passed_s[0] / step_s) :]
    times_s = step_s * np.arange(len(place_m), dtype=float)
    least_up_m = _LEAST_UP_SHARE * float(draft.places_m[:, 2].min())
    stays_up = run.completed and bool(place_m[:, 2].min() >= least_up_m)
    return SimulatedDraft(draft, times_s, place_m, passed_s - passed_s[0], stays_up, copter.has_error)


def places_of(positions: list[float]) -> Floats:
    """Positions that are numbers one after another as an array (k, 3)."""
    return np.fromiter(positions, float, len(positions)).reshape(-1, AXES)


def copter_after_takeoff(draft: Draft, limits: Limits, step_s: float, takeoff: Takeoff) -> Copter:
    """A copter as AUTO finds it: over the first place, the climb of its take-off over.

    Of a way up or down to that place only the end is flown: after it the vehicle is not quite at rest, and
    what follows begins 0.2 s later than from rest.
    """
    north_m, east_m, up_m = draft.places_m[0].tolist()
    if takeoff.up_m is not None:
        up_m += min(max(takeoff.up_m - up_m, -_LAST_PART_M), _LAST_PART_M)
    return Copter(limits, position_m=(north_m, east_m, up_m), step_s=step_s, home_amsl_m=takeoff.amsl_m)


def items_of(draft: Draft, limits: Limits, *, every_speed: bool = False) -> tuple[list[LocalItem], list[int]]:
    """Mission items with the draft's speed changes, or one before each leg, and the numbers of the places."""
    items: list[LocalItem] = []
    seqs = []
    climbs_m_s, speeds_m_s = draft.speed_changes(limits)
    columns = (draft.places_m, climbs_m_s, speeds_m_s, draft.hold_s, draft.spline)
    rows = zip(*(column.tolist() for column in columns), strict=True)
    for i, (place, climb_m_s, speed_m_s, hold_s, is_spline) in enumerate(rows):
        if isfinite(climb_m_s):
            items.append(climb_item(len(items) + FIRST_SEQ, climb_m_s))
        if isfinite(speed_m_s) or (every_speed and i > 0):
            items.append(_speed(len(items) + FIRST_SEQ, speed_m_s))
        seqs.append(len(items) + FIRST_SEQ)
        items.append(_waypoint(seqs[-1], tuple(place), hold_s, is_spline))
    return items, seqs


def items_changed(
    items: list[LocalItem], seqs: list[int], before: Draft, after: Draft, limits: Limits
) -> list[LocalItem]:
    """The mission items of a draft that has as many places and speed changes as one before it.

    Args:
        items: those of the draft before; where heights change, with the speeds of each leg.
        seqs: the numbers of its places.
        before: the draft before.
        after: the draft, its places at the same heights.
        limits: what the vehicle may do.
    """
    changed = items.copy()
    new_place = (before.places_m != after.places_m).any(axis=1) | (before.hold_s != after.hold_s)
    for i in np.flatnonzero(new_place | (before.spline != after.spline)).tolist():
        place, hold_s, is_spline = (
            tuple(after.places_m[i].tolist()),
            float(after.hold_s[i]),
            bool(after.spline[i]),
        )
        changed[seqs[i] - FIRST_SEQ] = _waypoint(seqs[i], place, hold_s, is_spline)
    for i in np.flatnonzero((before.speed_m_s != after.speed_m_s) & np.isfinite(after.speed_m_s)).tolist():
        seq = seqs[i] - 1
        changed[seq - FIRST_SEQ] = _speed(seq, float(after.speed_m_s[i]))
    if np.ptp(after.places_m[:, 2]) > 0:
        old_m_s, new_m_s = before.climbs_m_s(limits), after.climbs_m_s(limits)
        for i in np.flatnonzero((old_m_s != new_m_s) & np.isfinite(old_m_s + new_m_s)).tolist():
            seq = seqs[i] - 2
            changed[seq - FIRST_SEQ] = climb_item(seq, float(new_m_s[i]))
    return changed


@lru_cache(maxsize=4096)
def _speed(seq: int, speed_m_s: float) -> LocalItem:
    return LocalItem(seq, Command.CHANGE_SPEED, change_speed(speed_m_s).params, None, None)


@lru_cache(maxsize=4096)
def climb_item(seq: int, climb_m_s: float) -> LocalItem:
    """The item that changes the climb speed, or the descent speed of one below 0."""
    return LocalItem(seq, Command.CHANGE_SPEED, change_climb_speed(climb_m_s).params, None, None)


@lru_cache(maxsize=4096)
def _waypoint(seq: int, place_m: Vector, hold_s: float, is_spline: bool) -> LocalItem:
    north, east, up = place_m
    command = Command.SPLINE_WAYPOINT if is_spline else Command.WAYPOINT
    return LocalItem(seq, command, (hold_s, 0.0, 0.0, 0.0), (north, east), up)


def _reached_s(reached: list[tuple[int, float]], seq: int, never_s: float) -> float:
    return next((time_s for item, time_s in reached if item == seq), never_s)
