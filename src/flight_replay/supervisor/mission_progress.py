"""Which items of a mission the vehicle has reached, and which somebody made it leave out.

ArduCopter tells of each item that it reached, and which one it flies to. The first may be lost, so a vehicle
on its way to an item counts as having reached those before. But another ground station may send it on to any
item (MISSION_SET_CURRENT), before AUTO too, and all that is told of that is the new number.
"""

from __future__ import annotations

from itertools import pairwise
from math import hypot

from flight_replay.events import VehicleState
from flight_replay.geometry.geodesy import Place, ground_distance_m
from flight_replay.mission.items import FIRST_SEQ, Mission

_FASTEST_M_S = 30.0
_BESIDE_M = 50.0
"""Corners are cut by some metres, and positions and items are not told at the same time."""
_SEVERAL_BESIDE_M, _LATE_S, _ACCELERATION_M_S2 = 3.0, 2.5, 5.0
"""Where several are passed between two reports they are so near to each other that no corner is cut by more:
at its speed the vehicle flies to all of them in the time between, and in that by which positions are late."""


class MissionProgress:
    """The items reached so far: ``reached`` holds when each was, by the vehicle's clock."""

    def __init__(self, mission: Mission | None = None) -> None:
        self._waypoints = mission.waypoints if mission else ()
        self._at: tuple[int, VehicleState] | None = None
        self._just_began = False
        self._left_out: set[int] = set()
        self.reached: dict[int, float] = {}
        self.jumps: list[str] = []
        """A sentence for each time that the vehicle was sent on."""

    def begin(self, state: VehicleState) -> None:
        """AUTO begins with the vehicle in a state: from there it flies to the first item."""
        self._at, self._just_began = (FIRST_SEQ, state), True

    def is_outdated(self, seq: int, state: VehicleState) -> bool:
        """Whether the item that the vehicle flies to is one from before AUTO: the first told may be."""
        just_began, self._just_began = self._just_began, False
        return just_began and bool(self._not_flown(seq, state))

    def reached_item(self, seq: int, state: VehicleState) -> list[int]:
        """The items reached by a report of one; a waypoint with a command behind it is reported once."""
        self._check_flown(seq, state)
        self._left_out.discard(seq)
        return self._reached_up_to(seq, state.time_s)

    def flies_to(self, seq: int, state: VehicleState, *, complete: bool = False) -> list[int]:
        """The items reached by a report of the item that the vehicle, in a state, flies to, or has flown."""
        self._check_flown(seq, state)
        self._at = max(seq, FIRST_SEQ), state
        return self._reached_up_to(seq if complete else seq - 1, state.time_s)

    def waypoints_among(self, seqs: list[int]) -> list[tuple[int, int]]:
        """Which of some items are waypoints: the item, and the waypoint's number.

        Nobody knows when a turn or speed change was begun: they count as reached once they were read.
        """
        numbers = {seq: number for number, (seq, _) in enumerate(self._waypoints, 1)}
        return [(seq, numbers[seq]) for seq in seqs if seq in numbers]

    def _not_flown(self, seq: int, now: VehicleState) -> list[int]:
        """The numbers of waypoints before an item, if the vehicle cannot have flown to all of them."""
        before, then = self._at or (0, now)
        if before < FIRST_SEQ:
            return []
        left_out = self._left_out_before(seq)
        numbers = [number for number, (at, _) in enumerate(self._waypoints, 1) if at in left_out]
        places: list[Place] = [then, *(item for at, item in self._waypoints if before <= at < seq)]
        way_m = sum(ground_distance_m(*leg) for leg in pairwise(places))
        return numbers if way_m > _longest_way_m(then, now, waypoints=len(numbers)) else []

    def _left_out_before(self, seq: int) -> set[int]:
        before = self._at[0] if self._at else seq
        return set(range(before, seq)) - self.reached.keys() - self._left_out

    def _check_flown(self, seq: int, now: VehicleState) -> None:
        """Leave out the items before one where the vehicle cannot have flown to all of them."""
        numbers = self._not_flown(seq, now)
        if not numbers:
            return
        self._left_out |= self._left_out_before(seq)
        which = f"waypoint {numbers[0]} was"
        if len(numbers) > 1:
            which = f"waypoints {numbers[0]} to {numbers[-1]} were"
        self.jumps.append(
            f"{which} not flown: another ground station sent the vehicle on to item {seq}; "
            "disconnect that station to fly all of them"
        )

    def _reached_up_to(self, last_seq: int, time_s: float) -> list[int]:
        known = self.reached.keys() | self._left_out
        found = [seq for seq in range(FIRST_SEQ, last_seq + 1) if seq not in known]
        self.reached.update(dict.fromkeys(found, time_s))
        return found


def _longest_way_m(then: VehicleState, now: VehicleState, *, waypoints: int) -> float:
    """How far a vehicle may have flown over waypoints between two states, metres."""
    step_s = now.time_s - then.time_s
    if waypoints == 1:
        return _BESIDE_M + _FASTEST_M_S * step_s
    speed_m_s = max(hypot(*state.velocity_m_s[:2]) for state in (then, now)) + _ACCELERATION_M_S2 * step_s
    return _SEVERAL_BESIDE_M + min(speed_m_s, _FASTEST_M_S) * (step_s + _LATE_S)
