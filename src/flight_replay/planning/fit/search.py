"""From a first draft to the best: fly it in the model, move its places, set its speeds, again and again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.gauss_newton import Pull, pulled, raised
from flight_replay.planning.fit.objective import PLAN_SHARE, Forecast, forecast, on_plan
from flight_replay.planning.fit.reference import Hover, Recording
from flight_replay.planning.fit.simulated_draft import Choose, flown
from flight_replay.planning.fit.speed_schedule import Pacer, speed_caps_m_s, worth_asking_for
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.flight.copter import STEP_S

SURROUNDINGS_M = 4.0
"""No waypoint is farther from the recording."""
_GAIN = 0.6
_EVEN_BEND = 0.003
_LEG_S = 1.4
_SHAPING_SHARE = 0.6
_FINER = 0.4
"""Where time counts, the last flights of the search leave the places alone and mend the speeds."""
# Fixes pull as the fourth power in the objective has it, and the planned path as much as the flown
# one; both less where that would cost time.
_URGENCY_POWER, _TIMED_URGENCY_POWER = 2.0, 1.0
_LEAST_URGENCY, _MOST_URGENCY = 0.5, 5.0


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """What to fit: the recording, its hovers, and what the vehicle may do.

    ``timed`` says whether the recorded speed is to be kept; ``step_s`` is the step of the model.
    """

    recording: Recording
    hovers: list[Hover]
    limits: Limits
    timed: bool
    step_s: float

    def fly(self, draft: Draft, choose: Choose | None = None) -> Forecast:
        """What a draft would look like in the air, with the speeds that are chosen on the way if they are."""
        air = flown(draft, self.limits, self.step_s, choose, self.recording.home_amsl_m)
        return forecast(air, self.recording, timed=self.timed)


def searched(task: Task, draft: Draft, *, bend: float, flights: int, tick: Callable[[], None]) -> Forecast:
    """The best of the drafts on the way from ``draft``.

    Args:
        task: what to fit.
        draft: where to begin.
        bend: weight against places that ask for sudden turns.
        flights: how many flights in the model.
        tick: called after each.
    """
    best = last = task.fly(_in_haste(task, draft) if task.timed else draft)
    pacer = _pacer(task, last) if task.timed else None
    for flight in range(1, flights):
        tick()
        if pacer is not None and flight == round(_SHAPING_SHARE * flights):
            # Speeds are mended in finer steps: coarse ones are early by a second in ten minutes.
            task = replace(task, step_s=max(STEP_S, _FINER * task.step_s))
            last = best = task.fly(best.draft)
        draft = last.draft
        if pacer is None or flight < _SHAPING_SHARE * flights:
            draft = _shaped(task, draft, last, _bends(task, last, bend))
        if pacer is not None:
            draft = pacer.plan(last, draft)
        last = task.fly(draft, pacer.choose if pacer else None)
        if pacer is not None:
            pacer.learn(last.flown)
        if last.objective_m < best.objective_m:
            best = last
    tick()
    return best


def _in_haste(task: Task, draft: Draft) -> Draft:
    """The draft at about the highest speeds worth asking for."""
    return replace(draft, speed_m_s=np.append(np.nan, worth_asking_for(_caps_m_s(task, draft)[1:])))


def _caps_m_s(task: Task, draft: Draft) -> Floats:
    leg = on_plan(draft, task.recording)[0]
    return speed_caps_m_s(leg, len(draft), task.recording)


def _pacer(task: Task, hasty: Forecast) -> Pacer:
    """What sets the speeds, knowing how long legs take at least."""
    draft = hasty.draft
    places = np.flatnonzero(draft.hold_s[1:] > 0) + 1
    waits = dict(zip(places.tolist(), task.hovers, strict=len(places) > 0))
    least_s = np.diff(hasty.passed_s, prepend=0.0) - np.append(0.0, draft.hold_s[1:])
    return Pacer(task.recording, waits, least_s, _caps_m_s(task, draft))


def _bends(task: Task, last: Forecast, bend: float) -> Floats:
    """Weights (n - 3,) against unevenness: where legs are short in time, uneven places mean jerks."""
    if not task.timed or len(last.draft) < 4:
        return np.full(max(len(last.draft) - 3, 0), _EVEN_BEND)
    legs_s = np.diff(last.passed_s)
    three_s = np.convolve(legs_s, np.ones(3) / 3, "valid")
    return np.asarray(_EVEN_BEND + bend * np.minimum(1.0, (_LEG_S / np.maximum(three_s, 0.1)) ** 6))


def _shaped(task: Task, draft: Draft, last: Forecast, bend: Floats) -> Draft:
    """The draft moved so that both what is flown and what is planned come nearer to the fixes."""
    if len(draft) < 2:
        return draft
    power, plan_share = (_TIMED_URGENCY_POWER, PLAN_SHARE) if task.timed else (_URGENCY_POWER, 1.0)
    pulls = [
        Pull(last.leg, last.part, last.ahead, off_m, share * _urgency(off_m, power))
        for off_m, share in ((last.flown_off_m, 1.0), (last.planned_off_m, plan_share))
    ]
    moved = _kept_near(pulled(draft, pulls, bend, _GAIN), task.recording)
    if np.ptp(task.recording.up_m) > 0:
        moved = raised(moved, last.leg, last.part, task.recording.up_m)
    return moved


def _kept_near(draft: Draft, recording: Recording) -> Draft:
    """The draft with no place farther from the recording than ``SURROUNDINGS_M``."""
    places = draft.places_m.copy()
    feet = recording.nearest_m(places[:, :2])
    off = places[:, :2] - feet
    apart = np.linalg.norm(off, axis=1, keepdims=True)
    places[:, :2] = feet + off * np.minimum(1.0, SURROUNDINGS_M / np.maximum(apart, 1e-9))
    return replace(draft, places_m=places)


def _urgency(off_m: Floats, power: float) -> Floats:
    """Weights (n,) that grow with the distance, so that no fix is left far from the path."""
    apart = np.linalg.norm(off_m, axis=1)
    usual = np.sqrt((apart**2).mean())
    return np.asarray(np.clip(apart / max(usual, 1e-6), _LEAST_URGENCY, _MOST_URGENCY) ** power)
