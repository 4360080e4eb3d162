"""The recorded heading flown again: CONDITION_YAW and DO_SET_ROI items beside a route's waypoints."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from flight_replay.exceptions import MissionError
from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.geodesy import LocalFrame
from flight_replay.geometry.movement import turn_deg
from flight_replay.mission.items import Mission, MissionItem, face
from flight_replay.mission.path import planned_path
from flight_replay.planning.duration import LONGEST_SIMULATED_M
from flight_replay.planning.heading.legs import PredictedFlight, legs_of
from flight_replay.planning.heading.turn_choice import LegItems, best_items
from flight_replay.planning.heading.turns import Response
from flight_replay.planning.route import Route

WORTH_DEG_S = 4.0
"""An item must lower the error by this: 2 degrees, within which ArduCopter is there, for 2 s."""
MEMORIES = (302, 649, 1305)
"""Items besides home on boards with 15, 16 (SITL too) and 32 KB of storage (StorageManager.cpp)."""
_PASSES = 3
_SHIFT_COST_DEG_S = 20.0
"""A vehicle that is late turns late, too: by the rate at which copters are mostly turned."""
_DEARER = 1.2
_OFF_DEG, _WORTH_TELLING_SHARE = 30.0, 0.1
"""Turns take their time: where a mission is turned as recorded, up to 4 % of its headings are so far off."""


def with_recorded_headings(route: Route, takeoff_m: float, *, timed: bool) -> Route:
    """The route with items that turn the vehicle as the recorded one was; notes say how many, and how well.

    The smallest memory that holds the mission and one item a leg holds it with all of them.

    Args:
        route: what will be flown, without heading items.
        takeoff_m: take-off altitude above home.
        timed: whether it flies in time with the recording, see ``PredictedFlight.wanted_deg``.
    """
    if not np.isfinite(route.wanted.heading_deg).any():
        return route.with_notes("The log has no heading; the vehicle turns its own way.")
    if route.path.length_m > LONGEST_SIMULATED_M:
        return route.with_notes("The route is too long to plan headings; the vehicle turns its own way.")
    try:
        mission, off_deg = _turned(route, takeoff_m, timed=timed)
    except MissionError as error:
        return route.with_notes(f"No heading is planned, the vehicle turns its own way. {error}")
    added = len(mission.items) - len(route.mission.items)
    turned = replace(route, mission=mission, path=planned_path(mission, route.frame))
    return turned.with_notes(
        _added_note(added, timed=timed), _off_note(off_deg, can_follow=route.recording.timed)
    )


def _turned(route: Route, takeoff_m: float, *, timed: bool) -> tuple[Mission, Floats]:
    """The best mission by the predicted heading error, and by how well it keeps the plan's time.

    Beside it how far off its headings (n,) are expected to be from the first waypoint on, where one was
    recorded.
    """
    mission, limits = route.mission, route.limits.limits
    flight = plan = PredictedFlight.of(route, takeoff_m)
    found, worth_deg_s = [], WORTH_DEG_S
    for _ in range(_PASSES):
        legs = legs_of(mission, flight, flight.wanted_deg(route.wanted, timed=timed))
        search = partial(best_items, legs, Response.of(limits), may_face=limits.mount_type == 0)
        items, worth_deg_s = _affordable_items(search, _room(mission), worth_deg_s / _DEARER)
        turned = replace(mission, items=tuple(_merged(mission.items, items, route.frame)))
        flight = PredictedFlight.of(replace(route, mission=turned), takeoff_m)
        off_deg = np.abs(turn_deg(flight.heading_deg, flight.wanted_deg(route.wanted, timed=timed)))
        known = np.isfinite(off_deg)
        cost = float(off_deg[known].mean()) if known.any() else 0.0
        cost += _SHIFT_COST_DEG_S * _shift_s(flight, plan)
        found.append((cost, turned, off_deg[known & (flight.time_s >= flight.begin_s[1])]))
    _, mission, off_deg = min(found, key=lambda each: each[0])
    return mission, off_deg


def _affordable_items(
    search: Callable[[float], tuple[LegItems, ...]], room: int, worth_deg_s: float
) -> tuple[tuple[LegItems, ...], float]:
    """The items that are worth it, dearer until there is room for all, and what they had to be worth."""
    worth_deg_s = max(worth_deg_s, WORTH_DEG_S)
    while sum(map(len, items := search(worth_deg_s))) > room:
        worth_deg_s *= _DEARER
    return items, worth_deg_s


def _shift_s(flight: PredictedFlight, plan: PredictedFlight) -> float:
    """How much later or sooner than planned the legs begin, on average."""
    late_s = (flight.begin_s - flight.begin_s[1]) - (plan.begin_s - plan.begin_s[1])
    return float(np.abs(late_s).mean())


def _room(mission: Mission) -> int:
    """How many items may be added."""
    needed = len(mission.items) + len(mission.waypoints)
    memory = next((each for each in MEMORIES if each >= needed), MEMORIES[-1])
    return max(memory - len(mission.items), 0)


def _merged(
    items: Sequence[MissionItem], added: Iterable[LegItems], frame: LocalFrame
) -> Iterator[MissionItem]:
    """A mission's items with those of each leg behind the DO items before its waypoint."""
    of_legs = iter(added)
    for item in items:
        if item.is_waypoint:
            leg = next(of_legs)
            yield from leg.turns
            if leg.roi_m is not None:
                (lat_deg,), (lon_deg,) = frame.to_degrees(np.array([leg.roi_m]))
                yield face(float(lat_deg), float(lon_deg), item.alt_m, item.frame)
        yield item


def _added_note(added: int, *, timed: bool) -> str:
    """A sentence on how many items were added, and when the vehicle is turned as recorded."""
    if not added:
        return "No item that turns the vehicle would bring its heading nearer to the recorded one."
    items_turn = ("item", "turns") if added == 1 else ("items", "turn")
    where = "" if timed else " at equal places, not at equal times"
    return "{} {} on top of the waypoints {} the vehicle as recorded{}.".format(added, *items_turn, where)


def _off_note(off_deg: Floats, *, can_follow: bool) -> str:
    """A sentence where many headings (n,) are expected to be far off, else nothing."""
    share = np.count_nonzero(off_deg > _OFF_DEG) / max(len(off_deg), 1)
    if share <= _WORTH_TELLING_SHARE:
        return ""
    next_step = "; --mode guided follows them more closely" if can_follow else ""
    return (
        f"{100.0 * share:.0f} % of the headings are expected to be more than {_OFF_DEG:.0f} degrees off, the "
        f"worst {off_deg.max():.0f} degrees{next_step}."
    )
