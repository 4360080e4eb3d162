"""The search among starts, and why it stops."""

from dataclasses import replace
from types import ModuleType

import numpy as np
import pytest

import flight_replay.planning.fit.search as search_module
from flight_replay.exceptions import MissionError
from flight_replay.planning.fit import timed_search, untimed_search
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.first_drafts.knot_selection import select_waypoints, selections
from flight_replay.planning.fit.first_drafts.line_simplification import douglas_peucker, straight_draft
from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.problem import Budget, FirstDraft, FitProblem
from flight_replay.planning.fit.reference import flat_frame, local_track
from flight_replay.planning.fit.rounds import State
from flight_replay.planning.fit.search import search
from flight_replay.planning.fit.simulated_draft import simulate_draft
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import (
    DIVE,
    along,
    budget,
    draft_of,
    recording_of,
    track_through,
    wander,
)


def problem_and_starts(*, timed: bool) -> tuple[FitProblem, list[FirstDraft]]:
    recording = local_track(wander(2), 20.0)
    problem = problem_for(recording, 20, Limits(), timed=timed)
    curved = select_waypoints(problem, 20).draft
    straight = straight_draft(recording, douglas_peucker(recording.north_east_m, 20))
    return problem, [FirstDraft(curved, {}), FirstDraft(straight, {})]


def test_no_start_is_better_than_what_is_found() -> None:
    """Speeds set and places moved, the objective is below that of every start."""
    for timed in (True, False):
        problem, starts = problem_and_starts(timed=timed)
        best, _ = search(problem, starts, 20, budget(60))
        assert best.objective_m < min(problem.evaluate(start.draft).objective_m for start in starts)


@pytest.mark.parametrize("timed", [True, False])
def test_what_is_found_is_what_items_hold(timed: bool) -> None:
    """And what was flown: nothing is rounded after the search."""
    problem, starts = problem_and_starts(timed=timed)
    problem = replace(problem, frame=flat_frame(wander(2)))
    best, _ = search(problem, starts, 20, budget(60))
    assert problem.held(best.draft) is best.draft
    assert best.objective_m == problem.on_board.evaluate(best.draft).objective_m


def test_a_search_says_why_it_stopped() -> None:
    """It ends when its flights are spent, or when no step is worth taking."""
    problem, starts = problem_and_starts(timed=True)
    assert "enough" in search(problem, starts[:1], 20, budget(1))[1]
    assert "gained" in search(problem, starts[:1], 20, budget(10_000))[1]


def test_the_next_best_start_goes_on_where_the_first_is_a_dead_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """A start that is best after a round is not the answer for that."""
    problem, (curved, _) = problem_and_starts(timed=False)
    gone_on = []

    def dead_end_first(problem: FitProblem, state: State, budget: Budget) -> State:
        gone_on.append(state.objective_m)
        return state if len(gone_on) < 2 else untimed_search.gone_on(problem, state, budget)

    way = replace(search_module._UNTIMED, gone_on=dead_end_first)
    monkeypatch.setattr(search_module, "_UNTIMED", way)
    best, _ = search(problem, [curved, curved], 20, budget(150))
    assert best.objective_m < gone_on[0]
    assert len(gone_on) == 2, "what exchanging leaves as it was does not go on again"


def stops_in_a_row() -> tuple[FitProblem, FirstDraft]:
    """A way without stops, and a draft with four of them."""
    way = [(0.0, 0.0), (30.0, 0.0), (31.0, 0.0), (32.0, 0.0), (33.0, 0.0), (60.0, 0.0), (90.0, 0.0)]
    problem = problem_for(local_track(along([way[0], way[-1]], 2.0), 20.0), len(way), Limits(), timed=True)
    waits = [6.0, 1, 1, 1, 1, 0, 0]
    return problem, FirstDraft(draft_of(way, [False, *[wait == 0 for wait in waits[1:]]], waits), {})


def test_stops_that_make_the_vehicle_late_are_left_out() -> None:
    """No step takes one away."""
    problem, start = stops_in_a_row()
    best, _ = search(problem, [start], len(start.draft), budget(40))
    assert np.count_nonzero(best.draft.hold_s) < np.count_nonzero(start.draft.hold_s)


def test_stops_that_make_the_vehicle_very_late_are_left_out_soon() -> None:
    """Not with what other steps leave of the budget; what is flown for that is told."""
    problem, start = stops_in_a_row()
    spent = budget(16)
    best, _ = search(problem, [start], len(start.draft), spent)
    assert np.count_nonzero(best.draft.hold_s) < np.count_nonzero(start.draft.hold_s)
    assert spent.flights > 16


def dive_problem(draft: Draft, *, timed: bool) -> FitProblem:
    """To follow what a vehicle flies of it."""
    return problem_for(recording_of(simulate_draft(draft, Limits(), 0.05)), 20, Limits(), timed=timed)


def test_where_the_vehicle_comes_down_no_search_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a dive at 12 m/s and one at 3 m/s the slow one does; if there is none, that is said."""
    monkeypatch.setattr(untimed_search, "with_straight_climbs", lambda draft: draft)
    slow = replace(DIVE, speed_m_s=np.where(np.isnan(DIVE.speed_m_s), np.nan, 3.0))
    problem, spent = dive_problem(slow, timed=False), budget(20)
    best, _ = search(problem, [FirstDraft(DIVE, {}), FirstDraft(slow, {})], 20, spent)
    assert best.flight.stays_up
    assert best.objective_m < 1.0
    with pytest.raises(MissionError, match="come down to less than half of its lowest planned height"):
        search(problem, [FirstDraft(DIVE, {})], 20, spent)


@pytest.mark.parametrize("way", [timed_search, untimed_search])
def test_where_the_vehicle_would_fall_out_of_a_curve_it_is_flown_straight(way: ModuleType) -> None:
    """On a flight that comes home at 9 m/s and descends there, as most do; the first draft is all curves."""
    corners_m, corners_s = np.array([(-150, 0, 20), (0, 0, 20), (0, 0, 5)]), [0.0, 17.0, 27.0]
    time_s = np.arange(0.0, 27.0, 0.25)
    fixes_m = np.column_stack([np.interp(time_s, corners_s, axis) for axis in corners_m.T])
    recording = local_track(track_through(fixes_m[:, :2], time_s, fixes_m[:, 2]), fixes_m[:, 2])
    problem = problem_for(recording, 12, Limits(), timed=way is timed_search)
    start = selections(problem, 12)[0]
    (begun,) = way.begun(problem, [start], budget(30))
    assert start.draft.spline[-2:].all()
    assert not begun.best.draft.spline[-2:].any()
    assert begun.best.flight.stays_up
