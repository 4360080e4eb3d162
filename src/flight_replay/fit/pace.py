"""When each place ought to be passed, and the speeds and waits that get the vehicle there at that time.

Being late adds up: a vehicle that cannot keep up in one stretch is late in all that follow, unless
it was early before or hurries after. With the time that each leg takes at least, the lateness that
costs the smallest distance in time is an isotonic regression: lateness may fall from one place to
the next only as fast as the vehicle can hurry (Barlow et al., 1972: pool adjacent violators).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flight_replay.fit.basis import Indices
from flight_replay.fit.draft import Draft
from flight_replay.fit.forecast import Forecast
from flight_replay.fit.recording import Hover, Recording
from flight_replay.geodesy import Floats

SLOWEST_M_S = 0.25
"""ArduCopter ignores speed changes below 0.2 m/s."""
FASTEST_M_S = 30.0
_HASTE = 1.5
_HASTE_M_S = 1.0
_MOST_CHANGE = 2.5
_CHANGE_POWER = 0.8
_SHORTEST_LEG_S = 0.05
_RECOVERY_S = 200.0
_LEAST_HOLD_S = 1.0


@dataclass(slots=True)
class Pacer:
    """Sets the speeds of a draft from forecast to forecast; what it learns on the way stays here.

    ``waits`` are the hovers by the index of the place that stands for each; ``least_s`` (n,) are the
    shortest times that legs were seen to take.
    """

    recording: Recording
    waits: dict[int, Hover]
    caps_m_s: Floats
    least_s: Floats | None = None

    def paced(self, forecast: Forecast, draft: Draft) -> Draft:
        """``draft``, which is the forecast's with its places moved, with better speeds and waits."""
        flown = forecast.draft
        passing_s = self._wanted_passing_s(forecast)
        wanted = np.diff(passing_s, prepend=0.0)
        moving = np.maximum(np.diff(forecast.passed_s, prepend=0.0) - flown.hold_s, _SHORTEST_LEG_S)
        least, first = self._learn(moving)
        chord = np.linalg.norm(np.diff(draft.places_m[:, :2], axis=0, prepend=draft.places_m[:1, :2]), axis=1)
        floor = least + np.minimum(flown.hold_s, _LEAST_HOLD_S)
        late = best_lateness_s(wanted, floor, np.maximum(chord, 0.1))
        goal = wanted + np.diff(late, prepend=0.0)
        if not first:
            behind = np.append(0.0, (forecast.passed_s - passing_s - late)[:-1]) * wanted / _RECOVERY_S
            goal -= np.clip(behind, -0.3 * goal, 0.3 * goal)
        hold = self._holds_s(flown, passing_s, goal, least)
        left = np.maximum(goal - hold, _SHORTEST_LEG_S)
        change = np.clip(moving / left, 1 / _MOST_CHANGE, _MOST_CHANGE) ** _CHANGE_POWER
        speed = 1.1 * chord / left if first else draft.speed_m_s * change
        speed = np.clip(speed, SLOWEST_M_S, self.caps_m_s)
        speed[0] = np.nan
        return replace(draft, speed_m_s=speed, hold_s=hold)

    def _learn(self, moving: Floats) -> tuple[Floats, bool]:
        """Shortest durations known by now, and whether nothing was known before."""
        first = self.least_s is None
        if self.least_s is None:
            self.least_s = moving
        else:
            self.least_s = np.where(moving < self.least_s, (self.least_s + moving) / 2, self.least_s)
        return self.least_s, first

    def _wanted_passing_s(self, forecast: Forecast) -> Floats:
        """When the recording passed (n,) where the vehicle is as it passes each place."""
        times = self.recording.time_s
        flown_s = np.maximum.accumulate(forecast.flown_s) + 1e-6 * np.arange(len(times))
        passing = np.interp(forecast.passed_s, flown_s, times)
        for place, hover in self.waits.items():
            passing[place] = times[hover.last]
        passing[0], passing[-1] = 0.0, times[-1]
        return np.asarray(np.maximum.accumulate(passing))

    def _holds_s(self, flown: Draft, passing_s: Floats, goal_s: Floats, least_s: Floats) -> Floats:
        """Whole seconds to wait: what is left of each hover's leg when the vehicle comes as recorded."""
        hold = flown.hold_s.copy()
        for place, hover in self.waits.items():
            begin = self.recording.time_s[hover.first]
            coming = max(begin - passing_s[place - 1], least_s[place])
            hold[place] = max(_LEAST_HOLD_S, round(goal_s[place] - coming))
        return hold


def speed_caps_m_s(leg: Indices, legs: int, recording: Recording) -> Floats:
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
    return np.clip(_HASTE * caps + _HASTE_M_S, 2 * SLOWEST_M_S, FASTEST_M_S)


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
