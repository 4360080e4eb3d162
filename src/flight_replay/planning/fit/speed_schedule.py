"""When each place ought to be passed, and the speeds and waits that get the vehicle there at that time.

The speeds are chosen in the model's air: as a leg begins, the vehicle is as late or early as it is,
and the leg's speed makes good a part of that. Being late adds up all the same: a vehicle that
cannot keep up in one stretch is late in all that follow, unless it was early before or hurries
after. With the time that each leg takes at least, the lateness that costs the smallest distance in
time is an isotonic regression: lateness may fall from one place to the next only as fast as the
vehicle can hurry (Barlow et al., 1972: pool adjacent violators).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.objective import CURVE_TOLERANCE_M, Evaluation
from flight_replay.planning.fit.reference import Hover, LocalTrack
from flight_replay.planning.fit.simulated_draft import SimulatedDraft

SLOWEST_M_S = 0.25
"""ArduCopter ignores speed changes below 0.2 m/s."""
FASTEST_M_S = 30.0
WORTH_A_CHANGE = 1.5
"""Speeds nearer to each other than this ratio are not worth an item of the mission."""
_SPEED_HEADROOM = 1.5
_SPEED_HEADROOM_M_S = 1.0
_RECOVERY_S = 4.0
_LEAST_SHARE = 0.25
_SHORTEST_LEG_S = 0.05
_LEAST_HOLD_S = 1.0
_LEARNING = 0.6
_MOST_FACTOR = 3.0


class SpeedSchedule:
    """Chooses speeds as legs begin; ``plan`` sets what it aims at, ``learn`` how legs answer to speeds.

    Args:
        recording: whose times count.
        waits: the hovers by the index of the place that stands for each.
        least_s: the time that each leg takes at least, waiting not counted (n,).
        caps_m_s: highest speed worth asking for on each leg (n,).
    """

    def __init__(
        self, recording: LocalTrack, waits: dict[int, Hover], least_s: Floats, caps_m_s: Floats
    ) -> None:
        self._recording = recording
        self._waits = waits
        self._least_s = least_s
        self._caps_m_s = caps_m_s
        self._factor = np.ones(len(caps_m_s))
        self._asked_s = np.zeros(len(caps_m_s))
        self._speed_m_s = [np.inf] * len(caps_m_s)
        self._goal_s: Floats = np.zeros(len(caps_m_s))
        self._arrival_s: Floats = self._goal_s
        self._length_m: Floats = self._goal_s

    def plan(self, evaluation: Evaluation, draft: Draft) -> Draft:
        """Aim at when the recording passed the evaluated places; returns ``draft`` with its waits set."""
        passing_s = self._wanted_passing_s(evaluation)
        wanted = np.diff(passing_s, prepend=0.0)
        path = draft.path(CURVE_TOLERANCE_M)
        steps = np.linalg.norm(np.diff(path.north_east_m, axis=0, prepend=path.north_east_m[:1]), axis=1)
        steps = np.hypot(steps, np.diff(path.up_m, prepend=path.up_m[0]))
        self._length_m = np.bincount(path.seq, steps, minlength=len(draft)).astype(float)
        floor = self._least_s + np.minimum(draft.hold_s, _LEAST_HOLD_S)
        late = best_lateness_s(wanted, floor, np.maximum(self._length_m, 0.1))
        self._goal_s = np.maximum.accumulate(passing_s + late)
        hold = self._holds_s(draft, passing_s)
        self._arrival_s = self._goal_s - hold
        return replace(draft, hold_s=hold)

    def choose(self, place: int, now_s: float) -> float:
        """Speed for the leg to ``place`` if that begins now."""
        begin_s = self._goal_s[place - 1]
        nominal_s = max(self._arrival_s[place] - begin_s, _SHORTEST_LEG_S)
        asked_s = nominal_s - (now_s - begin_s) * min(1.0, nominal_s / _RECOVERY_S)
        self._asked_s[place] = asked_s = max(asked_s, _LEAST_SHARE * nominal_s)
        speed = self._factor[place] * self._length_m[place] / asked_s
        speed = float(min(max(speed, SLOWEST_M_S), self._caps_m_s[place]))
        before = self._speed_m_s[place - 1]
        near = max(speed, before) <= WORTH_A_CHANGE * min(speed, before)
        self._speed_m_s[place] = before if near else speed
        return self._speed_m_s[place]

    def learn(self, flown: SimulatedDraft) -> None:
        """Correct the speed of each leg by how much longer than asked for it took."""
        moving = np.maximum(np.diff(flown.passed_s, prepend=0.0) - flown.draft.hold_s, _SHORTEST_LEG_S)
        self._least_s = np.where(moving < self._least_s, (self._least_s + moving) / 2, self._least_s)
        answer = (moving / np.maximum(self._asked_s, _SHORTEST_LEG_S)) ** _LEARNING
        self._factor = np.clip(self._factor * answer, 1 / _MOST_FACTOR, _MOST_FACTOR)

    def _wanted_passing_s(self, evaluation: Evaluation) -> Floats:
        """When the recording passed (n,) where the vehicle is as it passes each place."""
        times = self._recording.time_s
        flown_s = np.maximum.accumulate(evaluation.flown_s) + 1e-6 * np.arange(len(times))
        passing = np.interp(evaluation.passed_s, flown_s, times)
        for place, hover in self._waits.items():
            passing[place] = times[hover.last]
        passing[0], passing[-1] = 0.0, times[-1]
        return np.asarray(np.maximum.accumulate(passing))

    def _holds_s(self, draft: Draft, passing_s: Floats) -> Floats:
        """Whole seconds to wait: what is left of each hover's leg when the vehicle comes as recorded."""
        hold = np.array(draft.hold_s)
        for place, hover in self._waits.items():
            coming_s = max(self._recording.time_s[hover.first] - passing_s[place - 1], self._least_s[place])
            hold[place] = max(_LEAST_HOLD_S, round(self._goal_s[place] - self._goal_s[place - 1] - coming_s))
        return hold


def speed_caps_m_s(leg: Indices, legs: int, recording: LocalTrack) -> Floats:
    """Highest speed worth asking for on each leg (legs,): half as fast again as recorded there.

    Args:
        leg: which leg each fix of the recording is on.
        legs: how many legs there are.
        recording: at least one fix.
    """
    speed = recording.speed_m_s
    caps = np.full(legs, np.nan)
    for here in np.unique(leg):
        caps[here] = np.percentile(speed[leg == here], 90)
    caps = np.where(np.isnan(caps), np.nanmax(caps), caps)
    return np.clip(_SPEED_HEADROOM * caps + _SPEED_HEADROOM_M_S, 2 * SLOWEST_M_S, FASTEST_M_S)


def without_small_changes(speeds_m_s: Floats) -> Floats:
    """The speeds (n,) without those so near to the one in force that they need no item; nan stands there."""
    kept = np.full(len(speeds_m_s), np.nan)
    in_force = np.inf
    for i, speed in enumerate(speeds_m_s.tolist()):
        if max(speed, in_force) > WORTH_A_CHANGE * min(speed, in_force):
            kept[i] = in_force = speed
    return kept


def best_lateness_s(wanted_s: Floats, least_s: Floats, weight: Floats) -> Floats:
    """Lateness (n,) at each place with the smallest weighted sum of sizes, zero at the first.

    Args:
        wanted_s: recorded duration of each leg (n,); that to the first place is not used.
        least_s: shortest duration of each leg (n,).
        weight: what a second of lateness costs around each place (n,).
    """
    forced = np.cumsum(np.append(0.0, (least_s - wanted_s)[1:]))
    # Lateness less what is forced never falls; it starts at 0, whatever that costs.
    return np.asarray(np.maximum(_rising_median(-forced, weight), 0.0) + forced)


def _rising_median(values: Floats, weight: Floats) -> Floats:
    """Never falling numbers nearest to ``values`` by weighted absolute distance."""
    pools: list[tuple[int, int, float]] = []
    for i, value in enumerate(values.tolist()):
        pool = (i, i + 1, value)
        while pools and pools[-1][2] > pool[2]:
            begin = pools.pop()[0]
            pool = (begin, pool[1], _median(values[begin : pool[1]], weight[begin : pool[1]]))
        pools.append(pool)
    return np.concatenate([np.full(end - begin, value) for begin, end, value in pools])


def _median(values: Floats, weight: Floats) -> float:
    order = np.argsort(values, kind="stable")
    total = np.cumsum(weight[order])
    return float(values[order][np.searchsorted(total, 0.5 * total[-1])])
