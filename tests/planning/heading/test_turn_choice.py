"""turn_choice.py: which items turn the vehicle on a leg."""

import numpy as np

from flight_replay.planning.heading.legs import SAMPLE_S, Leg
from flight_replay.planning.heading.turn_choice import best_items
from flight_replay.planning.heading.turns import Response
from flight_replay.simulator.dynamics.limits import Limits


def test_a_leg_has_fewer_items_than_arducopter_passes_by() -> None:
    """However long a hover turns to and fro, its waypoint is found."""
    time_s = np.arange(0.0, 600.0, SAMPLE_S)
    hover = Leg(time_s, 40.0 * np.sin(1.7 * time_s), np.full_like(time_s, np.nan), np.zeros((len(time_s), 2)))
    (items,) = best_items([hover], Response.of(Limits()), 0.01)
    assert 150 < len(items) < 245
