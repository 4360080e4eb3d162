"""Where a copter is after each step of a part of its mission, which a search asks for most of all.

Positions are numbers one after another, north, east and up, three for each step: tuples take much longer to
make and to look into.
"""

from __future__ import annotations

from math import hypot
from typing import Final

from flight_replay.exceptions import MissionError
from flight_replay.simulator.flight.auto import MissionRun
from flight_replay.simulator.flight.copter import Copter

_LONGEST_S: Final = 100_000.0
_NEARLY: Final = 1.0 - 1e-12
AXES: Final = 3
"""How many numbers a position is."""


def positions_on_leg(copter: Copter, seq: int, most_steps: float) -> list[float]:
    """The positions until the leg to item ``seq`` of the mission is about to end, or after so many steps."""
    run = _mission_of(copter)
    positions: list[float] = []
    steps = 0.0  # mypyc compares an integer with a number as objects.
    while steps < most_steps and not run.ends_item(seq):
        _step(copter, positions)
        steps += 1.0
    return positions


def positions_to_end(copter: Copter) -> list[float]:
    """The positions until the mission is completed, or the vehicle is on the ground before.

    Raises:
        MissionError: neither comes about.
    """
    run = _mission_of(copter)
    positions: list[float] = []
    while not run.completed and not copter.landed:
        _step(copter, positions)
        if copter.time_s > _LONGEST_S:
            raise MissionError("the fitted flight does not end; fit a shorter part of the log")
    return positions


def positions_after(copter: Copter, steps: int) -> list[float]:
    """The positions after each of so many steps, the mission completed or not."""
    positions: list[float] = []
    for _ in range(steps):
        _step(copter, positions)
    return positions


def passed_s(copter: Copter) -> float:
    """When the target passed the waypoint of the leg that is about to end, seconds since AUTO began."""
    return _mission_of(copter).passed_s


def longest_step_m(positions: list[float]) -> float:
    """The greatest distance over the ground between positions one step apart, 0 without any."""
    longest_m = enough_m2 = 0.0
    if not positions:
        return longest_m
    last_n, last_e = positions[0], positions[1]
    for i in range(AXES, len(positions), AXES):
        north, east = positions[i], positions[i + 1]
        n, e = north - last_n, east - last_e
        last_n, last_e = north, east
        # Few are so long that it is worth a call to know their length to the last bit.
        if n * n + e * e >= enough_m2:
            longest_m = max(longest_m, hypot(n, e))
            enough_m2 = longest_m * longest_m * _NEARLY
    return longest_m


def _step(copter: Copter, positions: list[float]) -> None:
    """Fly one step, and append where that leads to."""
    copter.step()
    n, e, u = copter.position_m
    positions.append(n)
    positions.append(e)
    positions.append(u)


def _mission_of(copter: Copter) -> MissionRun:
    run = copter.mission
    assert run is not None, "a draft is flown in AUTO"
    return run
