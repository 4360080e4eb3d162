"""Of a step that failed as a whole, what is better for it is kept."""

import numpy as np

from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.reference import local_track
from flight_replay.planning.fit.steps.better_parts import cheapest_sequence, places_better
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import along

PLACES = 11
PROBLEM = problem_for(local_track(along([(0.0, 0.0), (200.0, 0.0)], 4.0), 20.0), 20, Limits(), timed=True)


def flown(*beside: int) -> Evaluation:
    """Straight on, but for some places that are 3 m beside the way."""
    places = np.column_stack([np.linspace(0.0, 200.0, PLACES), np.zeros(PLACES), np.full(PLACES, 20.0)])
    places[list(beside), 1] = 3.0
    hold_s = np.append(1.0, np.zeros(PLACES - 1))
    speeds = np.append(np.nan, np.full(PLACES - 1, 4.0))
    return PROBLEM.evaluate(Draft(places, hold_s == 0, hold_s, speeds))


def test_places_are_taken_where_the_trial_is_better() -> None:
    """It comes back to the way at one place, and leaves it at another."""
    better = places_better(flown(2), flown(8))
    assert better[2]
    assert not better[8]


def test_the_cheapest_sequence_is_the_cheapest_of_all() -> None:
    """Of all that there are of three rows and five columns."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        costs, switch = rng.uniform(0, 1, (3, 5)), float(rng.uniform(0, 0.5))
        every = np.stack(np.meshgrid(*[np.arange(3)] * 5, indexing="ij"), axis=-1).reshape(-1, 5)
        total = costs[every, np.arange(5)].sum(axis=1) + switch * (np.diff(every, axis=1) != 0).sum(axis=1)
        assert cheapest_sequence(costs, switch).tolist() == every[total.argmin()].tolist()


def test_too_small_a_gain_is_not_worth_a_change() -> None:
    """One column is cheaper by less than two changes cost."""
    costs = np.array([[0.0, 0.0, 1.5, 0.0, 0.0], [1.0, 1.0, 0.0, 1.0, 1.0]])
    assert cheapest_sequence(costs, 1.0).tolist() == [0] * 5
    assert cheapest_sequence(costs, 0.7).tolist() == [0, 0, 1, 0, 0]
