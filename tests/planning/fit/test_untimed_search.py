"""The search at the vehicle's own speed: which starts are begun with, and that going on leads further."""

from dataclasses import replace

import pytest

from flight_replay.planning.fit import rounds, untimed_search
from flight_replay.planning.fit.first_drafts.knot_selection import selections
from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.problem import Budget, FirstDraft, FitProblem
from flight_replay.planning.fit.reference import local_track
from flight_replay.planning.fit.rounds import State
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import budget, wander


def problem_and_starts(seed: int = 2) -> tuple[FitProblem, list[FirstDraft]]:
    problem = problem_for(local_track(wander(seed), 20.0), 20, Limits(), timed=False)
    return problem, selections(problem, 20)


def test_as_many_starts_as_there_is_time_for_are_begun() -> None:
    """One always; others only if what comes of them can still be searched."""
    problem, starts = problem_and_starts()
    begun = [len(untimed_search.begun(problem, starts, budget(flights))) for flights in (1, 80, 1000)]
    assert begun[0] == 1
    assert 1 < begun[1] < begun[2]


def test_a_hopeless_start_has_no_round_and_goes_no_further(monkeypatch: pytest.MonkeyPatch) -> None:
    """One that is half as bad again as the best."""
    problem, starts = problem_and_starts()
    good = problem.evaluate(starts[0].draft)
    bad = replace(good, late_off_m=good.late_off_m + 100.0)
    found, after = [good, bad], []

    def rounded(_problem: FitProblem, state: State, _budget: Budget) -> State:
        after.append(state.best)
        return state

    monkeypatch.setattr(untimed_search, "flown", lambda *_: found.pop(0))
    monkeypatch.setattr(rounds, "rounded", rounded)
    (kept,) = untimed_search.begun(problem, [starts[0]] * 2, budget(1000))
    assert kept.best is good
    assert after == [good]


def test_going_on_leads_further_and_ends_with_the_budget() -> None:
    """By a tenth from where a first round ended."""
    problem, starts = problem_and_starts()
    (state,) = untimed_search.begun(problem, starts[:1], budget(20))
    spent = budget(120)
    found = untimed_search.gone_on(problem, state, spent)
    assert found.objective_m < 0.9 * state.objective_m
    assert spent.spent < 160
    assert untimed_search.gone_on(problem, state, budget(0)).best is state.best
