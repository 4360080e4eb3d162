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
