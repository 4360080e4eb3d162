"""The fit in one go: flown part, hovers, first draft, search, and the answer in words and numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from flight_replay.compare import Spread, in_order_distances, in_time, spread
from flight_replay.decimate import MAX_POINTS
from flight_replay.errors import LogError
from flight_replay.fit.draft import Draft
from flight_replay.fit.flown import flown_part, recording_of
from flight_replay.fit.forecast import Forecast
from flight_replay.fit.knots import first_draft
from flight_replay.fit.recording import Recording, hovers
from flight_replay.fit.result import FitResult
from flight_replay.fit.search import Task, searched
from flight_replay.geodesy import Floats
from flight_replay.option_types import RECORDED, Recorded
from flight_replay.path import planned_path
from flight_replay.simulator.limits import Limits
from flight_replay.track import Track

WORK_FIXES = 1000
"""Fixes that the search looks at; the errors of the answer are those of all fixes."""
_HOVER_SHARE = 3
_STEP_S = 0.04
_WORK_S = 9000.0
"""Seconds of flight that the search may simulate; at least ``_FEWEST_FLIGHTS`` flights, whatever it takes."""
_FEWEST_FLIGHTS, _MOST_FLIGHTS = 5, 16
_BEND = 0.1

Progress = Callable[[int, int], None]


def fit(  # noqa: PLR0913
    track: Track,
    *,
    max_points: int = MAX_POINTS,
    altitude_m: float | Recorded = 30.0,
    speed_m_s: float | Recorded | None = None,
    limits: Limits | None = None,
    progress: Progress | None = None,
) -> FitResult:
    """The mission whose flown path follows the flown part of ``track`` best.

    Args:
        track: fixes of one vehicle.
        max_points: most waypoints; speed changes come on top.
        altitude_m: height above home, constant or as recorded (never below 5 m).
        speed_m_s: ground speed, as recorded, or None for the vehicle's own setting.
        limits: what the vehicle may do; ArduCopter's defaults if None.
        progress: told how much of the work is done, and how much there is.

    Raises:
        LogError: the track holds no fix.
    """
    if not len(track):
        raise LogError("The log holds no position that could be followed; choose another log or vehicle.")
    flown, notes = flown_part(track)
    timed = speed_m_s == RECORDED
    recording = recording_of(flown, None if altitude_m == RECORDED else float(altitude_m))
    work = recording.thinned(WORK_FIXES)
    most = (max_points - 2) // _HOVER_SHARE
    waits = hovers(work, most) if most > 0 else []
    task = Task(work, flown.frame, waits, limits or Limits(), timed, _STEP_S)
    best = _search(task, max_points, None if timed else speed_m_s, progress or (lambda done, total: None))
    return _result(best, flown, recording, task, notes)


def _search(task: Task, max_points: int, speed_m_s: float | Recorded | None, progress: Progress) -> Forecast:
    """The best draft found with the flights that there is time for."""
    recording = task.recording
    if len(recording) < 2 or max_points < 2:
        return task.fly(_single(recording))
    draft = first_draft(recording, max_points, task.hovers, timed=task.timed)
    if isinstance(speed_m_s, float):
        draft = replace(draft, speed_m_s=np.append(speed_m_s, draft.speed_m_s[1:]))
    flights = int(np.clip(_WORK_S / max(recording.time_s[-1], 1.0), _FEWEST_FLIGHTS, _MOST_FLIGHTS))
    done = 0

    def tick() -> None:
        nonlocal done
        done += 1
        progress(done, flights)

    return searched(task, draft, bend=_BEND, flights=flights, tick=tick)


def _single(recording: Recording) -> Draft:
    """One waypoint, where the recording ends."""
    place = np.append(recording.north_east_m[-1], recording.up_m[-1])
    return Draft(place[None], np.zeros(1, np.bool_), np.zeros(1), np.full(1, np.nan))


def _result(
    best: Forecast, flown: Track, recording: Recording, task: Task, notes: tuple[str, ...]
) -> FitResult:
    """The answer, its errors measured against every fix."""
    frame = flown.frame
    mission = best.draft.mission(frame)
    final = replace(task, recording=recording).fly(best.draft)
    path = planned_path(mission, frame)
    return FitResult(
        mission=mission,
        flown=flown,
        frame=frame,
        planned=_spread(in_order_distances(recording.north_east_m, path.north_east_m)),
        predicted_space=_spread(np.linalg.norm(final.flown_off_m, axis=1)),
        predicted_time=_spread(
            in_time(recording.time_s, recording.north_east_m, final.flown.time_s, final.flown.place_m[:, :2])
        ),
        predicted_duration_s=float(final.passed_s[-1]),
        objective_m=final.objective_m,
        time_s=final.flown.time_s,
        place_m=final.flown.place_m,
        notes=notes,
    )


def _spread(distances_m: Floats) -> Spread:
    found = spread(distances_m)
    assert found is not None, "a recording has fixes"
    return found
