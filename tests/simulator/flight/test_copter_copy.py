"""A copy of a copter flies on as the copter does, whatever it was doing, and leaves it alone."""

import pytest

from flight_replay.mission.items import Command
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.flight.copter import Copter
from flight_replay.simulator.flight.copter_copy import _copied, copter_copy
from flight_replay.simulator.mission.local_items import DO_JUMP, LocalItem, Params

Item = tuple[int, Params, tuple[float, float] | None]

NONE: Params = (0.0, 0.0, 0.0, 0.0)
HOLD: Params = (2.0, 0.0, 0.0, 0.0)


def speed(m_s: float) -> Item:
    return Command.CHANGE_SPEED, (1.0, m_s, 0.0, 0.0), None


def to(command: int, north_m: float, east_m: float, params: Params = NONE) -> Item:
    return command, params, (north_m, east_m)


STRAIGHT, SPLINE = Command.WAYPOINT, Command.SPLINE_WAYPOINT
CORNERS = [
    speed(6),
    to(STRAIGHT, 0, 0),
    to(STRAIGHT, 40, 0),
    speed(9),
    to(STRAIGHT, 40, 40),
    to(STRAIGHT, 0, 60),
]
CURVES = [to(STRAIGHT, 0, 0), to(SPLINE, 30, 0), speed(3), to(SPLINE, 30, 30), to(SPLINE, 0, 30, HOLD)]
MIXED = [
    to(STRAIGHT, 0, 0, HOLD),
    to(SPLINE, 30, 0),
    to(STRAIGHT, 60, 20),
    to(STRAIGHT, 60, 60),
    to(SPLINE, 30, 60),
    to(STRAIGHT, 0, 30, HOLD),
    to(STRAIGHT, 0, 30),
]
OTHERS: list[Item] = [
    to(STRAIGHT, 20, 0),
    (Command.CONDITION_YAW, (90.0, 20.0, 1.0, 0.0), None),
    to(STRAIGHT, 40, 0),
    (DO_JUMP, (1.0, 1.0, 0.0, 0.0), None),
    to(Command.LOITER_TURNS, 40, 10, (1.0, 0.0, 8.0, 0.0)),
    (Command.DELAY, HOLD, None),
    (Command.SET_ROI, NONE, (0.0, 0.0)),
    to(SPLINE, 0, 20),
    (Command.RETURN_TO_LAUNCH, NONE, None),
]
LANDING: list[Item] = [to(STRAIGHT, 10, 0), to(Command.LAND, 20, 0)]


def items_of(mission: list[Item]) -> list[LocalItem]:
    return [
        LocalItem(seq, command, params, place, None if place is None else 15.0 + seq % 3)
        for seq, (command, params, place) in enumerate(mission, 1)
    ]


def copter_flying(items: list[LocalItem], limits: Limits = Limits()) -> Copter:  # noqa: B008
    copter = Copter(limits, position_m=(0.0, 0.0, 20.0), step_s=0.1, wind_m_s=(1.0, 0.5, 0.0))
    copter.start_auto(items)
    return copter


def motions(copter: Copter, steps: int) -> list[tuple[float, ...]]:
    rows: list[tuple[float, ...]] = []
    for _ in range(steps):
        copter.step()
        rows.append((*copter.motion, *copter.attitude_rad, *copter.target_m, copter.throttle))
    return rows


@pytest.mark.parametrize("mission", [CORNERS, CURVES, MIXED, OTHERS, LANDING])
def test_copies_fly_as_the_copter_does(mission: list[Item]) -> None:
    """To the last bit, from every second of missions with corners, curves, stops and other items."""
    items = items_of(mission)
    usual = copter_flying(items)
    whole = motions(usual, 1500)
    copter, rows = copter_flying(items), []
    for begin in range(0, 1400, 10):
        copied = copter_copy(copter)
        assert motions(copied, 60) == whole[begin : begin + 60]
        rows += motions(copter, 10)
    assert rows == whole[:1400]
    copied = copter_copy(copter)
    motions(copied, 100)
    assert usual.mission is None or (copied.mission and copied.mission.reached == usual.mission.reached)


def test_a_copy_flies_other_items_if_they_are_given() -> None:
    """The copter goes on to its own next place, the copy to another."""
    items = items_of(CORNERS)
    others = [*items[:-1], LocalItem(6, STRAIGHT, NONE, (80.0, 40.0), 15.0)]
    copter = copter_flying(items)
    motions(copter, 20)
    copied = copter_copy(copter, others)
    end, other_end = (position_at_end(each) for each in (copter, copied))
    assert end == pytest.approx((0.0, 60.0, 15.0), abs=0.5)
    assert other_end == pytest.approx((80.0, 40.0, 15.0), abs=0.5)


def position_at_end(copter: Copter) -> Vector:
    motions(copter, 600)
    return copter.position_m


def test_what_is_neither_copied_nor_shared_is_an_error() -> None:
    """A new part is not forgotten: copies would share it."""
    with pytest.raises(TypeError, match="set: neither copied"):
        _copied(set(), {})
    with pytest.raises(TypeError, match="Copter: in a list"):
        _copied([copter_flying(items_of(CORNERS))], {})
