"""What it costs to be later, and what it gains to be sooner."""

import numpy as np

from flight_replay.planning.fit.legs.lateness import Lateness


def lateness(late_s: list[float], spare_s: list[float]) -> Lateness:
    return Lateness(np.array(late_s), np.array(spare_s), np.ones(len(late_s)))


def test_a_delay_lasts_until_there_is_time_to_spare() -> None:
    """Two seconds are late for two legs, of which the second can make good one, and then no more."""
    on_time = lateness([0.0] * 5, [0.0, 0.0, 1.0, 5.0, 0.0])
    assert on_time.cost_m(0, 2.0) == 2.0 + 1.0
    after = on_time.later(0, 2.0)
    assert after.late_s.tolist() == [0.0, 2.0, 1.0, 0.0, 0.0]
    assert after.spare_s.tolist() == [0.0, 0.0, 0.0, 4.0, 0.0]


def test_a_gain_is_worth_something_where_the_vehicle_is_late() -> None:
    """Who is on time already gains nothing by being sooner."""
    assert lateness([0.0, 3.0, 1.0, 0.0, 4.0], [0.0] * 5).cost_m(0, -2.0) == -3.0
    assert lateness([0.0] * 4, [0.0] * 4).cost_m(0, -2.0) == 0.0


def test_how_late_one_may_be_for_a_cost() -> None:
    """It is the delay whose cost comes to that, to a tenth of a second."""
    on_time = lateness([0.0] * 4, [0.0, 0.0, 1.0, 9.0])
    assert on_time.cost_m(0, 3.0) == 3.0 + 2.0
    assert 3.0 <= on_time.most_later_s(0, 5.0) <= 3.1
