"""The search where the recorded speed is kept: among starts, by what they exchange, and on from there."""

from dataclasses import replace

import pytest

from flight_replay.planning.fit import rounds, timed_search
from flight_replay.planning.fit.draft import with_every_speed
from flight_replay.planning.fit.first_drafts.knot_selection import selections
from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.problem import FirstDraft, FitProblem
from flight_replay.planning.fit.reference import local_track
from flight_replay.planning.fit.search import search
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import budget, wander


def problem_and_starts(seed: int = 2) -> tuple[FitProblem, list[FirstDraft]]:
    problem = problem_for(local_track(wander(seed), 20.0), 20, Limits(), timed=True)
    return problem, selections(problem, 20)


def test_what_several_starts_come_to_is_as_good_as_what_one_does() -> None:
    """They exchange stretches, the best goes on, and so do the others while there is time."""
    problem, starts = problem_and_starts(4)
    alone, _ = search(problem, starts[:1], 20, budget(80))
    together, _ = search(problem, starts, 20, budget(160))
    assert together.objective_m < 1.005 * alone.objective_m


def test_as_many_starts_as_there_is_time_for_are_begun() -> None:
    """One always; others only if the best of them can still be searched."""
    problem, starts = problem_and_starts(9)
    begun = [len(timed_search._rounded(problem, starts, budget(flights))) for flights in (10, 90, 1000)]
    assert begun == [1, 2, 4]


def test_the_first_start_has_its_round_if_there_is_time_for_that_alone() -> None:
    """As for a recording of hours, which is flown a few times only."""
    problem, starts = problem_and_starts(9)
    (as_it_is,) = timed_search._rounded(problem, starts, budget(5))
    (after_round,) = timed_search._rounded(problem, starts, budget(20))
    assert after_round.best.objective_m < as_it_is.best.objective_m


@pytest.mark.parametrize("after_round", [False, True])
def test_a_hopeless_start_goes_no_further(monkeypatch: pytest.MonkeyPatch, after_round: bool) -> None:
    """One that is half as bad again as the best is not worth a round, or not worth steps after it."""
    problem, starts = problem_and_starts()
    good, bad = (problem.evaluate(start.draft) for start in starts[:2])
    bad = replace(bad, late_off_m=bad.late_off_m + 100.0)
    found, after = [good, good if after_round else bad], [good, bad] if after_round else [good]
    monkeypatch.setattr(timed_search, "flown_on_schedule", lambda *_: found.pop(0))
    monkeypatch.setattr(rounds, "rounded", lambda _p, s, _b: replace(s, best=after.pop(0)))
    (kept,) = timed_search._rounded(problem, starts[:2], budget(1000))
    assert kept.best is good
    assert not after


def test_places_are_left_in_time_in_steps_as_on_board() -> None:
    """Speeds that make the vehicle late there are set anew; where that is no better, they stay."""
    problem, (start, *_) = problem_and_starts()
    found = rounds.flown_on_schedule(problem.exact, start.draft, start.hovers, budget(100))
    draft, on_board = with_every_speed(found.draft), problem.on_board
    slow = replace(draft, speed_m_s=0.9 * draft.speed_m_s)
    late = replace(found, flight=replace(found.flight, draft=slow))
    in_time, as_it_was = timed_search.timed_finely(problem, late), on_board.evaluate(slow)
    assert abs(as_it_was.passed_s - found.passed_s).max() > 1.0
    assert abs(in_time.passed_s - found.passed_s).max() < 0.2
    assert in_time.objective_m == on_board.evaluate(in_time.draft).objective_m
    assert timed_search.timed_finely(problem, found).objective_m <= on_board.evaluate(draft).objective_m


def test_hours_are_not_timed_in_steps_as_on_board() -> None:
    """Flights of hours would take a gigabyte; they are judged in steps that they can afford."""
    problem, _ = problem_and_starts()
    recording = problem.recording
    hours = replace(
        problem, recording=replace(recording, time_s=recording.time_s * 4000.0 / recording.time_s[-1])
    )
    assert problem.on_board.step_s == 0.0025
    assert hours.on_board.step_s == hours.exact.step_s == problem.step_s
