"""What is found as mission items hold it: degrees to 1e-7, which are steps of a centimetre.

The shorter a leg between two waits, the more that changes: one of a centimetre takes a second, as the time to
come from rest to rest goes with the cube root of the way, and one of none takes no time at all. All that
comes after is sooner or later by as much.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.planning.fit.draft import Draft, with_every_speed
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.rounds import WORTH_GOING_ON, better, flown_on_time
from flight_replay.planning.fit.speed_schedule import LEAST_HOLD_S, Schedule, speed_caps_m_s

_DECIMALS = 7


def as_items_hold_it(problem: FitProblem, found: Evaluation, frame: FlatFrame) -> Evaluation:
    """What a search has found, in the items' steps; on time again, where these have made it worse.

    Args:
        problem: what to fit.
        found: in exact steps of the model.
        frame: the metres of the fit, around home.
    """
    exact = problem.exact
    stored = exact.evaluate(_on_grid(found.draft, frame))
    if not problem.timed or stored.objective_m <= (1 + WORTH_GOING_ON) * found.objective_m:
        return stored
    hold_s = _waits_s(stored.draft, found.passed_s - stored.passed_s)
    again = with_every_speed(replace(stored.draft, hold_s=hold_s))
    caps_m_s = speed_caps_m_s(again, problem.recording)
    return better(stored, flown_on_time(exact, Schedule(again, found.passed_s), caps_m_s)[0])


def _on_grid(draft: Draft, frame: FlatFrame) -> Draft:
    places_m = draft.places_m.copy()
    lat_deg, lon_deg = frame.to_degrees(places_m[:, :2])
    places_m[:, :2] = frame.to_metres(lat_deg.round(_DECIMALS), lon_deg.round(_DECIMALS))
    return replace(draft, places_m=places_m)


def _waits_s(draft: Draft, early_s: Floats) -> Floats:
    """Whole seconds to wait at each place (n,), where the draft's are left so much too early (n,)."""
    hold_s: Floats = draft.hold_s.copy()
    added_s = 0.0
    for place in 1 + np.flatnonzero(hold_s[1:-1] > 0):
        hold_s[place] = max(LEAST_HOLD_S, hold_s[place] + round(float(early_s[place]) - added_s))
        added_s += hold_s[place] - draft.hold_s[place]
    return hold_s
