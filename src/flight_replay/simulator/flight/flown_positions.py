"""Where a copter is after each step of a part of its mission, which a search asks for most of all."""

from __future__ import annotations

from typing import Final

from flight_replay.exceptions import MissionError
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.flight.auto import MissionRun
from flight_replay.simulator.flight.copter import Copter

_LONGEST_S: Final = 100_000.0


def positions_on_leg(copter: Copter, seq: int, most_steps: float) -> list[Vector]:
    """The positions until the leg to item ``seq`` of the mission is about to end, or after so many steps."""
    run = _mission_of(copter)
    positions: list[Vector] = []
    while len(positions) < most_steps and not run.ends_item(seq):
        copter.step()
        positions.append(copter.position_m)
    return positions


def positions_to_end(copter: Copter) -> list[Vector]:
    """The positions until the mission is completed.

    Raises:
        MissionError: it does not end.
    """
    run = _mission_of(copter)
    positions: list[Vector] = []
    while not run.completed:
        copter.step()
        positions.append(copter.position_m)
        if copter.time_s > _LONGEST_S:
            raise MissionError("the fitted flight does not end; fit a shorter part of the log")
    return positions


def positions_after(copter: Copter, steps: int) -> list[Vector]:
    """The positions after each of so many steps, the mission completed or not."""
    positions: list[Vector] = []
    for _ in range(steps):
        copter.step()
        positions.append(copter.position_m)
    return positions


def _mission_of(copter: Copter) -> MissionRun:
    run = copter.mission
    assert run is not None, "a draft is flown in AUTO"
    return run
