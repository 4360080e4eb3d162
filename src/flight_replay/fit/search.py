"""From a first draft to the best: fly it in the model, move its places, set its speeds, again and again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from flight_replay.fit.draft import Draft
from flight_replay.fit.forecast import PLAN_SHARE, Forecast, forecast, on_plan
from flight_replay.fit.pace import Pacer, speed_caps_m_s
from flight_replay.fit.recording import Hover, Recording
from flight_replay.fit.shape import Pull, pulled, raised
from flight_replay.geodesy import Floats, LocalFrame
from flight_replay.simulator.limits import Limits

_GAIN = 0.6
_EVEN_BEND = 0.003
_LEG_S = 1.4


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """What to fit: the recording in metres of ``frame``, its hovers, and what the vehicle may do.

    ``timed`` says whether the recorded speed is to be kept; ``step_s`` is the step of the model.
    """

    recording: Recording
    frame: LocalFrame
    hovers: list[Hover]
    limits: Limits
    timed: bool
    step_s: float

    def fly(self, draft: Draft) -> Forecast:
        """What a draft would look like in the air."""
        return forecast(draft, self.recording, self.frame, self.limits, timed=self.timed, step_s=self.step_s)


def searched(  # noqa: PLR0913
    task: Task, draft: Draft, *, bend: float, shaping: int, pacing: int, tick: Callable[[], None]
) -> Forecast:
    """The best of the drafts on the way from ``draft``: first places and speeds, then speeds alone.

    Args:
        task: what to fit.
        draft: where to begin.
        bend: weight against places that ask for sudden turns.
        shaping: how many flights to move places after.
        pacing: how many more to set speeds after.
        tick: called after each flight in the model.
    """
    pacer = _pacer(task, draft) if task.timed else None
    if pacer is not None:
        draft = replace(draft, speed_m_s=np.append(np.nan, pacer.caps_m_s[1:]))
    best: Forecast | None = None
    for flight in range(shaping + (pacing if pacer else 0)):
        flown = task.fly(draft)
        tick()
        if best is None or flown.objective_m < best.objective_m:
            best = flown
        probing = pacer is not None and flight == 0
        if flight < shaping and not probing:
            draft = _shaped(task, draft, flown, _bends(task, flown, bend))
        if pacer is not None:
            draft = pacer.paced(flown, draft)
    assert best is not None, "there is at least one flight"
    return best


def _pacer(task: Task, draft: Draft) -> Pacer:
    leg = on_plan(draft, task.recording)[0]
    places = np.flatnonzero(draft.hold_s[1:] > 0) + 1
    waits = dict(zip(places.tolist(), task.hovers, strict=True))
    return Pacer(task.recording, waits, speed_caps_m_s(leg, len(draft), task.recording))


def _bends(task: Task, flown: Forecast, bend: float) -> Floats:
    """Weights (n - 3,) against unevenness: where legs are short in time, uneven places mean jerks."""
    if not task.timed:
        return np.full(max(len(flown.draft) - 3, 0), _EVEN_BEND)
    legs_s = np.diff(flown.passed_s)
    three_s = np.convolve(legs_s, np.ones(3) / 3, "valid")
    return np.asarray(_EVEN_BEND + bend * np.minimum(1.0, (_LEG_S / np.maximum(three_s, 0.1)) ** 6))


def _shaped(task: Task, draft: Draft, flown: Forecast, bend: Floats) -> Draft:
    """The draft moved so that both what is flown and what is planned come nearer to the fixes."""
    weight = np.ones(len(flown.leg))
    pulls = [
        Pull(flown.leg, flown.part, flown.ahead, flown.flown_off_m, weight),
        Pull(flown.leg, flown.part, flown.ahead, flown.planned_off_m, PLAN_SHARE * weight),
    ]
    moved = pulled(draft, pulls, bend, _GAIN)
    if np.ptp(task.recording.up_m) > 0:
        moved = raised(moved, flown.leg, flown.part, task.recording.up_m)
    return moved
