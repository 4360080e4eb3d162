"""From a first draft to the best: fly it in the model, move its places, set its speeds, again and again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.gauss_newton import Residuals, gauss_newton_step, with_fitted_heights
from flight_replay.planning.fit.objective import PLAN_SHARE, Evaluation, evaluate, match_to_plan
from flight_replay.planning.fit.reference import Hover, LocalTrack
from flight_replay.planning.fit.simulated_draft import ChooseSpeed, simulate_draft
from flight_replay.planning.fit.speed_schedule import SpeedSchedule, speed_caps_m_s, without_small_changes
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.flight.copter import STEP_S

CORRIDOR_M = 4.0
"""No waypoint is farther from the recording."""
_GAIN = 0.6
_MIN_SMOOTHING = 0.003
_LEG_S = 1.4
_SHAPING_SHARE = 0.6
_FINER = 0.4
"""Where time counts, the last flights of the search leave the places alone and correct the speeds."""
# Fixes weigh as the fourth power in the objective has it, and the planned path as much as the flown
# one; both less where that would cost time.
_WEIGHT_POWER, _TIMED_WEIGHT_POWER = 2.0, 1.0
_MIN_WEIGHT, _MAX_WEIGHT = 0.5, 5.0


@dataclass(frozen=True, slots=True, eq=False)
class FitProblem:
    """What to fit: the recording, its hovers, and what the vehicle may do.

    ``timed`` says whether the recorded speed is to be kept; ``step_s`` is the step of the model.
    """

    recording: LocalTrack
    hovers: list[Hover]
    limits: Limits
    timed: bool
    step_s: float

    def evaluate(self, draft: Draft, choose: ChooseSpeed | None = None) -> Evaluation:
        """How a draft is flown, with its own speeds or with those that ``choose`` sets as legs begin."""
        air = simulate_draft(draft, self.limits, self.step_s, choose, self.recording.home_amsl_m)
        return evaluate(air, self.recording, timed=self.timed)


def search(
    problem: FitProblem, draft: Draft, *, smoothing: float, flights: int, tick: Callable[[], None]
) -> Evaluation:
    """The best of the drafts that the search passes from ``draft`` on.

    Args:
        problem: what to fit.
        draft: where to begin.
        smoothing: weight against places that ask for sudden turns.
        flights: how many flights in the model.
        tick: called after each.
    """
    best = last = problem.evaluate(_at_highest_speeds(problem, draft) if problem.timed else draft)
    schedule = _schedule(problem, last) if problem.timed else None
    for flight in range(1, flights):
        tick()
        if schedule is not None and flight == round(_SHAPING_SHARE * flights):
            # Speeds are corrected in finer steps: coarse ones are early by a second in ten minutes.
            problem = replace(problem, step_s=max(STEP_S, _FINER * problem.step_s))
            last = best = problem.evaluate(best.draft)
        draft = last.draft
        if schedule is None or flight < _SHAPING_SHARE * flights:
            draft = _moved_to_fixes(problem, draft, last, _smoothing_weights(problem, last, smoothing))
        if schedule is not None:
            draft = schedule.plan(last, draft)
        last = problem.evaluate(draft, schedule.choose if schedule else None)
        if schedule is not None:
            schedule.learn(last.flown)
        if last.objective_m < best.objective_m:
            best = last
    tick()
    return best


def _at_highest_speeds(problem: FitProblem, draft: Draft) -> Draft:
    """The draft at about the highest speeds worth asking for."""
    return replace(draft, speed_m_s=np.append(np.nan, without_small_changes(_caps_m_s(problem, draft)[1:])))


def _caps_m_s(problem: FitProblem, draft: Draft) -> Floats:
    leg = match_to_plan(draft, problem.recording)[0]
    return speed_caps_m_s(leg, len(draft), problem.recording)


def _schedule(problem: FitProblem, fastest: Evaluation) -> SpeedSchedule:
    """What sets the speeds, knowing how long legs take at least."""
    draft = fastest.draft
    places = np.flatnonzero(draft.hold_s[1:] > 0) + 1
    waits = dict(zip(places.tolist(), problem.hovers, strict=len(places) > 0))
    least_s = np.diff(fastest.passed_s, prepend=0.0) - np.append(0.0, draft.hold_s[1:])
    return SpeedSchedule(problem.recording, waits, least_s, _caps_m_s(problem, draft))


def _smoothing_weights(problem: FitProblem, last: Evaluation, smoothing: float) -> Floats:
    """Weights (n - 3,) against unevenness: where legs are short in time, uneven places mean jerks."""
    if not problem.timed or len(last.draft) < 4:
        return np.full(max(len(last.draft) - 3, 0), _MIN_SMOOTHING)
    legs_s = np.diff(last.passed_s)
    three_s = np.convolve(legs_s, np.ones(3) / 3, "valid")
    return np.asarray(_MIN_SMOOTHING + smoothing * np.minimum(1.0, (_LEG_S / np.maximum(three_s, 0.1)) ** 6))


def _moved_to_fixes(problem: FitProblem, draft: Draft, last: Evaluation, smoothing: Floats) -> Draft:
    """The draft moved so that both what is flown and what is planned come nearer to the fixes."""
    if len(draft) < 2:
        return draft
    power, plan_share = (_TIMED_WEIGHT_POWER, PLAN_SHARE) if problem.timed else (_WEIGHT_POWER, 1.0)
    residuals = [
        Residuals(last.leg, last.part, last.direction, off_m, share * _residual_weights(off_m, power))
        for off_m, share in ((last.flown_off_m, 1.0), (last.planned_off_m, plan_share))
    ]
    moved = _kept_in_corridor(gauss_newton_step(draft, residuals, smoothing, _GAIN), problem.recording)
    if np.ptp(problem.recording.up_m) > 0:
        moved = with_fitted_heights(moved, last.leg, last.part, problem.recording.up_m)
    return moved


def _kept_in_corridor(draft: Draft, recording: LocalTrack) -> Draft:
    """The draft with no place farther from the recording than ``CORRIDOR_M``."""
    places = draft.places_m.copy()
    feet = recording.nearest_m(places[:, :2])
    off = places[:, :2] - feet
    apart = np.linalg.norm(off, axis=1, keepdims=True)
    places[:, :2] = feet + off * np.minimum(1.0, CORRIDOR_M / np.maximum(apart, 1e-9))
    return replace(draft, places_m=places)


def _residual_weights(off_m: Floats, power: float) -> Floats:
    """Weights (n,) that grow with the distance, so that no fix is left far from the path."""
    apart = np.linalg.norm(off_m, axis=1)
    usual = np.sqrt((apart**2).mean())
    return np.asarray(np.clip(apart / max(usual, 1e-6), _MIN_WEIGHT, _MAX_WEIGHT) ** power)
