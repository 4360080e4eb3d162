"""Where a copter is after each step of a part of its mission, which a search asks for most of all."""

from __future__ import annotations

from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.flight.copter import Copter


def positions_on_leg(copter: Copter, seq: int, most_steps: float) -> list[Vector]:
    """The positions until the leg to item ``seq`` of the mission is about to end, or after so many steps."""
    run = copter.mission
    assert run is not None, "a draft is flown in AUTO"
    positions: list[Vector] = []
    while len(positions) < most_steps and not run.ends_item(seq):
        copter.step()
        positions.append(copter.position_m)
    return positions


def positions_to_end(copter: Copter, most_steps: float) -> list[Vector]:
    """The positions until the mission is completed, or after so many steps."""
    run = copter.mission
    assert run is not None, "a draft is flown in AUTO"
    positions: list[Vector] = []
    while len(positions) < most_steps and not run.completed:
        copter.step()
        positions.append(copter.position_m)
    return positions


def positions_after(copter: Copter, steps: int) -> list[Vector]:
    """The positions after each of so many steps, the mission completed or not."""
    positions: list[Vector] = []
    for _ in range(steps):
        copter.step()
        positions.append(copter.position_m)
    return positions
