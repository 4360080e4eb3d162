"""Stretches exchanged between drafts: what is better of each comes together."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from flight_replay.geometry.arrays import Floats
from flight_replay.planning.fit.chains.exchange import exchanged
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.reference import Hover, local_track
from flight_replay.planning.fit.rounds import State
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import along, budget

LENGTH_M, SPEED_M_S = 200.0, 4.0


def problem() -> FitProblem:
    track = along([(0.0, 0.0), (LENGTH_M, 0.0)], SPEED_M_S)
    return problem_for(local_track(track, 20.0), 20, Limits(), timed=True)


def state(problem: FitProblem, off_m: Floats, north_m: Sequence[float] = ()) -> State:
    """Straight on in equal legs, or through such places, but for how far each is beside the way."""
    n = len(off_m)
    places = np.column_stack([north_m or np.linspace(0.0, LENGTH_M, n), off_m, np.full(n, 20.0)])
    hold_s = np.append(1.0, np.zeros(n - 1))
    draft = Draft(places, hold_s == 0, hold_s, np.append(np.nan, np.full(n - 1, SPEED_M_S)))
    return State(problem.evaluate(draft), {})


def bumps(*at: int, places: int = 11) -> Floats:
    off_m = np.zeros(places)
    off_m[list(at)] = 3.0
    return off_m


def test_each_draft_gives_what_it_is_better_in() -> None:
    """One strays in the beginning, the other in the end; what comes of both strays nowhere."""
    here = problem()
    states = [state(here, bumps(2)), state(here, bumps(8))]
    spent = budget(100)
    found = exchanged(here, states, 20, spent)
    assert np.abs(found.best.draft.places_m[:, 1]).max() == 0.0
    assert found.best.objective_m < min(each.best.objective_m for each in states)
    assert spent.spent > 0


def test_there_are_no_more_places_than_are_allowed() -> None:
    """A stretch of more places is taken only if there may be so many."""
    here = problem()
    few, many = state(here, bumps(2)), state(here, bumps(14, 16, 18, places=21))
    assert len(exchanged(here, [few, many], 11, budget(100)).best.draft) == 11
    assert len(exchanged(here, [few, many], 30, budget(100)).best.draft) > 11


def test_a_stretch_for_which_there_is_no_room_comes_with_a_shorter_one() -> None:
    """As many places more where the one strays as there are less where both fly straight on."""
    here = problem()
    north = [0, 5, 10, 20, 30, 40, 60, 80, 100, 120, 140, 160, 180, 200]
    other_north = [0, 20, 40, 60, 80, 100, 120, 140, 160, 170, 180, 190, 195, 200]
    late = state(here, np.where(np.array(north) == 160, 3.0, 0.0), north)
    early = state(here, np.where(np.array(other_north) == 100, 3.0, 0.0), other_north)
    found = exchanged(here, [late, early], 14, budget(100)).best.draft
    assert len(found) <= 14
    assert np.abs(found.places_m[:, 1]).max() == 0.0


def test_hovers_stay_with_their_places() -> None:
    """Both drafts wait at the same places, where they come together with others before them."""
    here = problem()
    first, second = Hover(20, 21, 5.0), Hover(80, 81, 6.0)

    def waiting(each: State, *places: int) -> State:
        hold_s = each.best.draft.hold_s.copy()
        hold_s[list(places)] = 1.0
        waits = replace(each.best.draft, hold_s=hold_s)
        return replace(
            each, best=here.evaluate(waits), hovers=dict(zip(places, (first, second), strict=True))
        )

    few = waiting(state(here, bumps(3)), 2, 8)
    many = waiting(state(here, bumps(14, 18, places=21)), 4, 16)
    found = exchanged(here, [few, many], 30, budget(100))
    draft = found.best.draft
    assert np.abs(draft.places_m[:, 1]).max() == 0.0
    waits = np.flatnonzero(draft.hold_s[1:]) + 1
    assert draft.places_m[waits, 0].tolist() == pytest.approx([40.0, 160.0])
    assert found.hovers == dict(zip(waits.tolist(), (first, second), strict=True))


def test_nothing_is_flown_without_time() -> None:
    """Without a flight left the best of the drafts is what there is."""
    here = problem()
    states = [state(here, bumps(2)), state(here, bumps(8))]
    found = exchanged(here, states, 20, budget(0))
    assert found is min(states, key=lambda each: each.best.objective_m)


def test_a_draft_that_is_cheapest_as_it_is_is_not_flown_again() -> None:
    """The other strays, and is nowhere better."""
    here = problem()
    straight, spent = state(here, bumps()), budget(100)
    assert exchanged(here, [state(here, bumps(2)), straight], 20, spent) is straight
    assert spent.spent == 0
