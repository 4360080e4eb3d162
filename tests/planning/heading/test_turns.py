"""turns.py: CONDITION_YAW items, and the heading that comes of them."""

import numpy as np
import pytest

from flight_replay.mission.items import Command
from flight_replay.planning.heading.turns import Response, Turns, followed_deg, knots
from flight_replay.simulator.dynamics.limits import Limits

RESPONSE = Response.of(Limits())


def test_a_turn_is_done_at_its_time() -> None:
    """Its rate leaves the time in which the vehicle settles; the target is at the heading by then."""
    turns = Turns(RESPONSE, 350.0)
    turns.turn(30.0, 2.0)
    assert turns.items[0].params[0] == 30.0
    assert 20.0 < turns.items[0].params[1] < 30.0
    assert turns.end_s == pytest.approx(2.0, abs=0.1)
    assert turns.targets_deg(np.array([0.0, 5.0])) == pytest.approx([350.0, 390.0])


def test_a_turn_that_is_too_fast_ends_later() -> None:
    """60 degrees a second is the most; a wide turn is told which way round."""
    turns = Turns(RESPONSE, 0.0)
    turns.turn(200.0, 1.0)
    assert turns.items[0].params[1:3] == (60.0, -1.0)
    assert turns.end_s > 160 / 60


def test_a_slow_turn_is_waited_for() -> None:
    """The next turn begins at its time all the same."""
    turns = Turns(RESPONSE, 0.0)
    turns.turn(3.0, 4.0)
    turns.turn(90.0, 6.0)
    assert [item.command for item in turns.items] == [
        Command.CONDITION_YAW,
        Command.CONDITION_DELAY,
        Command.CONDITION_YAW,
    ]
    assert turns.targets_deg(np.array([4.0]))[0] == pytest.approx(3.0, abs=0.1)


def test_a_vehicle_follows_its_target() -> None:
    """Not faster than it can, and not at all where there is no target."""
    headings = followed_deg(0.0, np.array([90.0] * 30 + [np.nan] * 5), 0.1, RESPONSE)
    assert headings[10] == pytest.approx(60.0, abs=1.0)
    assert headings[29] == pytest.approx(90.0, abs=1.0)
    assert headings[34] == headings[30]


def test_knots_follow_headings_ever_closer() -> None:
    """One more where the lines are farthest off, until that is close enough."""
    times_s = np.arange(11.0)
    headings_deg = np.where(times_s < 5, 0.0, 20.0 * (times_s - 5))
    assert knots(times_s, headings_deg, 4, 2.0) == [[10], [5, 10]]


def test_wide_turns_are_parted() -> None:
    """A turn of 400 degrees is three of the short way, however straight it is."""
    times_s = np.arange(41.0)
    assert knots(times_s, 10.0 * times_s, 4, 2.0) == [[14, 27, 40]]
    assert knots(times_s, -10.0 * times_s, 4, 2.0) == [[14, 27, 40]]


def test_lists_of_knots_grow_by_a_third() -> None:
    """So that a leg with many turns has few of them to try; the last is the closest."""
    times_s = np.arange(41.0)
    lengths = [len(each) for each in knots(times_s, 30.0 * (times_s % 2), 20, 2.0)]
    assert lengths == [1, 2, 3, 4, 6, 8, 11, 15, 20]


def test_a_slow_turn_after_another_item_is_as_slow_as_wanted() -> None:
    """The first one is not: what it begins with is not as certain."""
    turns = Turns(RESPONSE, 0.0)
    turns.turn(0.0, 0.0)
    turns.turn(60.0, 20.0)
    assert turns.items[-1].params[1] == pytest.approx(3.0, abs=0.1)
    assert turns.targets_deg(np.array([10.0]))[0] == pytest.approx(30.0, abs=1.0)


def test_a_heading_that_stays_between_turns_is_one_wait() -> None:
    """No turn of nothing is asked for."""
    turns = Turns(RESPONSE, 0.0)
    for heading_deg, until_s in [(45.0, 2.0), (45.5, 5.0), (44.5, 8.0), (90.0, 10.0)]:
        turns.turn(heading_deg, until_s)
    commands = [item.command for item in turns.items]
    assert commands == [Command.CONDITION_YAW, Command.CONDITION_DELAY, Command.CONDITION_YAW]
    assert turns.targets_deg(np.array([8.0]))[0] == pytest.approx(45.0, abs=0.1)
