"""Positions of a part of a mission are those after each step, and a mission that never ends is an error."""

from itertools import pairwise
from math import hypot

import pytest

from flight_replay.exceptions import MissionError
from flight_replay.mission.items import Command
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.flight.copter import Copter
from flight_replay.simulator.flight.flown_positions import (
    AXES,
    longest_step_m,
    positions_after,
    positions_on_leg,
    positions_to_end,
)
from flight_replay.simulator.mission.local_items import LocalItem


def waypoint(seq: int, north_m: float, command: int = Command.WAYPOINT) -> LocalItem:
    return LocalItem(seq, command, (0.0, 0.0, 0.0, 0.0), (north_m, 0.0), 20.0)


def copter_in_auto(items: list[LocalItem], step_s: float = 0.05) -> Copter:
    copter = Copter(Limits(), position_m=(0.0, 0.0, 20.0), step_s=step_s)
    copter.start_auto(items)
    return copter


def test_parts_of_a_mission_are_those_of_the_whole() -> None:
    """The first leg, then the rest, step by step as a flight in one go has them."""
    items = [waypoint(1, 30.0), waypoint(2, 60.0)]
    copter, other = copter_in_auto(items), copter_in_auto(items)
    positions = positions_on_leg(copter, 1, 10_000)
    assert positions[-AXES] == pytest.approx(30.0, abs=3.0)
    assert copter.mission is not None
    assert copter.mission.ends_item(1)
    positions += positions_to_end(copter)
    assert copter.mission.completed
    assert positions == positions_after(other, len(positions) // AXES)


def test_a_leg_is_flown_for_no_more_steps_than_asked_for() -> None:
    """A trial that takes too long is cut short."""
    copter = copter_in_auto([waypoint(1, 3000.0)])
    assert len(positions_on_leg(copter, 1, 40)) == 40 * AXES
    assert not positions_on_leg(copter, 1, -1)


def test_the_longest_step_is_that_of_all_to_the_last_bit() -> None:
    """Over the ground, however near to each other the longest are."""
    positions = positions_after(copter_in_auto([waypoint(1, 100.0), waypoint(2, 200.0)]), 300)
    steps_m = [
        hypot(there[0] - here[0], there[1] - here[1])
        for here, there in pairwise(zip(positions[::AXES], positions[1::AXES], strict=True))
    ]
    assert longest_step_m(positions) == max(steps_m) > 0.2
    assert longest_step_m(positions[:AXES]) == longest_step_m([]) == 0.0


def test_a_mission_that_does_not_end_is_an_error() -> None:
    """A loiter without an end; in steps of 100 s it is soon found out."""
    copter = copter_in_auto([waypoint(1, 0.0, Command.LOITER_UNLIMITED)], step_s=100.0)
    with pytest.raises(MissionError, match="does not end"):
        positions_to_end(copter)
