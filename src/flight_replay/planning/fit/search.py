"""From first drafts to the best.

Which waypoints a draft begins with decides where a search ends, and little that can be seen before tells
which are good. So there are several starts, without places that make them late where that is much better.
They exchange stretches, and what comes of that goes on as far as it leads; it takes stretches from them once
more, and loses such places. The others go on, too, one by one, while there is time, each exchanging with the
best.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from flight_replay.exceptions import MissionError
from flight_replay.planning.fit import timed_search, untimed_search
from flight_replay.planning.fit.chains.exchange import EXCHANGE_FLIGHTS, exchanged
from flight_replay.planning.fit.mends.curve_leaps import without_leaps
from flight_replay.planning.fit.mends.leg_errors import without_errors
from flight_replay.planning.fit.mends.spline_dives import without_dives
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import Budget, FirstDraft, FitProblem
from flight_replay.planning.fit.rounds import COMES_DOWN, ENOUGH, NO_MORE, WORTH_GOING_ON, State
from flight_replay.planning.fit.steps.fewer_places import with_fewer_places


@dataclass(frozen=True, slots=True)
class _Way:
    """How starts are begun with, and what is found goes on, at the recorded or the vehicle's own speed."""

    begun: Callable[[FitProblem, list[FirstDraft], Budget], list[State]]
    gone_on: Callable[[FitProblem, State, Budget], State]
    another_flights: float


_SOON_SHARE = 0.5
"""Flights besides the search, as a share of its own, to tell whether a start is late for places too many."""
_SOON_ANEW = 4
"""So many of the changes tried then are flown with speeds set anew, too, which takes about five flights."""
_COSTLY = 0.6
"""In starts but the best, places are tried if being late after them is so much of the objective."""
_MUCH_BETTER = 0.8
"""A start goes on without them if it is no worse than this share of the best of all."""

_TIMED = _Way(timed_search.begun, timed_search.gone_on, timed_search.ANOTHER_FLIGHTS)
_UNTIMED = _Way(untimed_search.begun, untimed_search.gone_on, untimed_search.ANOTHER_FLIGHTS)


def search(
    problem: FitProblem, starts: list[FirstDraft], most: int, budget: Budget
) -> tuple[Evaluation, str]:
    """The best draft of at most ``most`` places that comes of some starts, and why the search stopped.

    The first of them has no more places.

    Raises:
        MissionError: in none of them the vehicle stays up.
    """
    way = _TIMED if problem.timed else _UNTIMED
    states = _relieved_soon(problem, way.begun(problem, starts, budget), budget)
    small_enough = [state for state in states if len(state.best.draft) <= most]
    if not small_enough:
        raise MissionError(COMES_DOWN)
    others = sorted(small_enough, key=lambda state: state.objective_m)[1:]
    best = _exchanged(problem, [], states, most, budget)
    if len(states) > 1 and budget.affords(EXCHANGE_FLIGHTS):
        best = _exchanged(problem, [best], states, most, budget)
    best = relieved = _relieved(problem, best, budget)
    for other in others:
        if not budget.affords(way.another_flights):
            break
        best = _exchanged(problem, [best, way.gone_on(problem, other, budget)], states, most, budget)
    stopped = NO_MORE if budget.affords(way.another_flights) else ENOUGH
    if best is not relieved:
        best = _relieved(problem, best, budget)
    budget.finish()
    timed = timed_search.timed_finely(problem, best.best) if problem.timed else best.best
    return without_errors(problem, without_leaps(problem, without_dives(problem, timed))), stopped


def _relieved_soon(problem: FitProblem, states: list[State], budget: Budget) -> list[State]:
    """The starts, each with fewer places if that is much better than all of them.

    A stop at the beginning may make all of a long flight late. No step makes up for it, and all try to.
    """
    if not problem.timed:
        return states
    best = min(states, key=lambda state: state.objective_m)
    flights = round(_SOON_SHARE * budget.flights)
    relieved = []
    for state in states:
        found, besides = state, Budget(flights, lambda done, total: None)
        least_cost = WORTH_GOING_ON if state is best else _COSTLY
        while (fewer := with_fewer_places(problem, found, besides, least_cost, _SOON_ANEW)) is not found:
            found = fewer
        budget.spend_besides(besides.spent)
        relieved.append(found if found.objective_m < _MUCH_BETTER * best.objective_m else state)
    return relieved


def _relieved(problem: FitProblem, best: State, budget: Budget) -> State:
    """The best with fewer places where they make it late, each time going on as far as there is time."""
    if not problem.timed:
        return best
    while (fewer := with_fewer_places(problem, best, budget)) is not best:
        best = timed_search.gone_on(problem, fewer, budget)
    return best


def _exchanged(
    problem: FitProblem, ended: list[State], begun: list[State], most: int, budget: Budget
) -> State:
    """The best that comes of some drafts as they exchange stretches; it goes on if it is new."""
    way = _TIMED if problem.timed else _UNTIMED
    found = exchanged(problem.exact, [*ended, *begun], most, budget)
    return found if any(found is each for each in ended) else way.gone_on(problem, found, budget)
