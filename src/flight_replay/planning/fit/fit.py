"""The fit in one go: flown part, first drafts, search, and the answer in words and numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from flight_replay.exceptions import LogError
from flight_replay.logs.track import Track
from flight_replay.planning.altitude import FLOOR_M, RECORDED, Recorded, home_of
from flight_replay.planning.fit.first_drafts.knot_selection import selections
from flight_replay.planning.fit.first_drafts.line_simplification import (
    corner_draft,
    douglas_peucker,
    straight_draft,
)
from flight_replay.planning.fit.first_drafts.whole_corners import with_whole_corners
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import Budget, FirstDraft, FitProblem
from flight_replay.planning.fit.reference import (
    ROOMY_HOVER_S,
    SHORTEST_HOVER_S,
    LocalTrack,
    flat_frame,
    hovers,
    local_track,
)
from flight_replay.planning.fit.result import FitResult, fit_notes
from flight_replay.planning.fit.search import search
from flight_replay.planning.flown_part import flown_part
from flight_replay.planning.heights import Heights, heights_of
from flight_replay.planning.spacing import MAX_POINTS
from flight_replay.simulator.dynamics.limits import Limits

WORK_FIXES = 1000
"""Fixes that the search, which takes memory by the square, looks at; the errors are those of all fixes."""
_HOVER_SHARE = 3
_ROOMY_LEG_S = 2.0
"""With fewer waypoints than one in so many seconds, stopping for a pause costs less than flying it slowly."""
# Durations of flights, and the steps of the model that can be afforded for each.
_STEPS_S = ((200.0, 600.0, 2000.0, 4000.0), (0.05, 0.08, 0.1, 0.1))
_WORK_STEPS, _WORK_STEPS_A_FIX = 1_000_000, 40
"""Steps of the model that the search may take, and more for each fix."""
_OTHER_STEPS = 600
"""At the vehicle's own speed, to compare a flight and move its places takes as long as so many steps."""
_FEWEST_FLIGHTS, _MOST_FLIGHTS = 8, 500

ProgressCallback = Callable[[int, int], None]


def fit(  # noqa: PLR0913
    track: Track,
    *,
    max_points: int = MAX_POINTS,
    altitude_m: float | Recorded = 30.0,
    floor_m: float = FLOOR_M,
    raise_m: float = 0.0,
    speed_m_s: float | Recorded | None = None,
    limits: Limits | None = None,
    takeoff_m: float | None = None,
    progress: ProgressCallback | None = None,
) -> FitResult:
    """The mission whose flown path follows the flown part of ``track`` best.

    Args:
        track: fixes of one vehicle.
        max_points: most waypoints, of which at most ``WORK_FIXES`` are used; speed changes come on top.
        altitude_m: height above home, constant or as recorded.
        floor_m: lower recorded heights are raised to this.
        raise_m: so much higher than recorded.
        speed_m_s: ground speed, as recorded, or None for the vehicle's own setting.
        limits: what the vehicle may do; ArduCopter's defaults if None.
        takeoff_m: height above home that the vehicle takes off to; None: that of the first waypoint.
        progress: told how much of the work is done, and how much there is.

    Raises:
        LogError: the track holds no fix.
        MissionError: whatever is tried, the vehicle would come down to less than half of its lowest height.
    """
    if not len(track):
        raise LogError("the log has no position to follow; choose another log or vehicle")
    flown, notes = flown_part(track)
    timed, limits, max_points = speed_m_s == RECORDED, limits or Limits(), min(max_points, WORK_FIXES)
    heights = heights_of(flown, altitude_m, floor_m, limits if timed else None, raise_m)
    recording = local_track(flown, heights.planned_m, takeoff_m)
    problem = replace(problem_for(recording, max_points, limits, timed=timed), frame=flat_frame(flown))
    budget = _budget(problem, len(flown), progress)
    best, spent = _searched(problem, recording, max_points, speed_m_s, budget)
    said, too_late = fit_notes(best, problem, max_points)
    return replace(_result(best, flown, heights, limits, (*notes, spent, *said)), cannot_keep_up=too_late)


def _searched(
    problem: FitProblem,
    recording: LocalTrack,
    max_points: int,
    speed_m_s: float | Recorded | None,
    budget: Budget,
) -> tuple[Evaluation, str]:
    """The best draft that comes of all starts, and a sentence on what it took and why it stopped."""
    # For matrices so small a second thread of the library waits more than it computes, and it waits busily.
    with threadpool_limits(1, user_api="blas"):
        starts = _at_speed(speed_m_s, _starts(problem, recording, max_points))
        best, stopped = search(problem, starts, max_points, budget)
    return best, f"Fitted in {budget.spent:.0f} simulations: {stopped}."


def problem_for(recording: LocalTrack, max_points: int, limits: Limits, *, timed: bool) -> FitProblem:
    """What the search looks at: some of the fixes, the longest hovers, steps that can be afforded."""
    work = recording.thinned(WORK_FIXES)
    most_hovers = max(1, (max_points - 2) // _HOVER_SHARE)
    step_s = float(np.interp(recording.time_s[-1], *_STEPS_S))
    is_roomy = timed and recording.time_s[-1] > _ROOMY_LEG_S * max_points
    shortest_s = ROOMY_HOVER_S if is_roomy else SHORTEST_HOVER_S
    waits = hovers(work, most_hovers, shortest_s) if max_points > 2 else []
    return FitProblem(work, waits, limits, timed, step_s)


def _budget(problem: FitProblem, fixes: int, progress: ProgressCallback | None) -> Budget:
    other_steps = 0 if problem.timed else _OTHER_STEPS
    steps_a_flight = problem.recording.time_s[-1] / problem.step_s + other_steps
    flights = (_WORK_STEPS + _WORK_STEPS_A_FIX * fixes) / max(steps_a_flight, 1.0)
    most = int(np.clip(flights, _FEWEST_FLIGHTS, _MOST_FLIGHTS))
    return Budget(most, progress or (lambda done, total: None))


def _at_speed(speed_m_s: float | Recorded | None, starts: list[FirstDraft]) -> list[FirstDraft]:
    """The starts with a speed set at the first place, where one is given."""
    if speed_m_s is None or speed_m_s == RECORDED:
        return starts
    drafts = [start.draft for start in starts]
    set_once = [replace(draft, speed_m_s=np.append(speed_m_s, draft.speed_m_s[1:])) for draft in drafts]
    return [replace(start, draft=draft) for start, draft in zip(starts, set_once, strict=True)]


def _starts(problem: FitProblem, recording: LocalTrack, max_points: int) -> list[FirstDraft]:
    """What the search begins with: waypoints where they are missed most, and at corners, as of missions."""
    last = len(recording) - 1
    if last == 0 or max_points < 2:
        return [FirstDraft(straight_draft(recording, np.array([last])), {})]
    selected = selections(problem, max_points)
    if problem.timed:
        cut = corner_draft(problem, max_points)
        whole = with_whole_corners(cut)
        return [*selected, cut, whole] if len(whole.draft) < len(cut.draft) else [*selected, cut]
    corners = straight_draft(recording, douglas_peucker(recording.north_east_up_m, max_points))
    return [*selected, FirstDraft(corners, {})]


def _result(
    best: Evaluation, flown: Track, heights: Heights, limits: Limits, notes: tuple[str, ...]
) -> FitResult:
    return FitResult(
        mission=best.draft.mission(flat_frame(flown), limits).with_home(home_of(flown)),
        flown=flown,
        heights=heights,
        flight=best.flight,
        predicted_duration_s=float(best.passed_s[-1]),
        objective_m=best.objective_m,
        notes=notes,
    )
