"""Where a mission leads along ways that were not recorded as flown: jumps of the position, and gaps."""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Flags, Floats
from flight_replay.geometry.polyline import segment_lengths_m
from flight_replay.logs.flights import find_flights
from flight_replay.logs.track import Track
from flight_replay.planning.flown_part import flown_fixes, flown_part
from flight_replay.planning.following.samples import jumps

GAP_S = 5.0
"""Recorded time: shorter gaps are hardly worth telling."""
_GAP_STEPS = 5.0
"""Of tracks with few fixes: a gap is so many usual steps."""
_MOST = 3
"""Of many the greatest are told."""


def unrecorded_notes(covered: Track) -> tuple[str, ...]:
    """Sentences on the jumps and gaps within the flights of a track, by the clock of what was flown."""
    if not covered.timed or len(covered) < 2:
        return ()
    flown, _ = flown_part(covered)
    time_s = flown.time_s - flown.time_s[0]
    steps_s, steps_m = np.diff(time_s), segment_lengths_m(flown.north_east_m())
    begins = np.isin(flown_fixes(covered)[1:], [flight.first for flight in find_flights(covered)])
    jump = jumps(steps_m, steps_s) & ~begins
    usual_s = float(np.median(steps_s)) if len(steps_s) else 0.0
    gap = (steps_s > max(GAP_S, _GAP_STEPS * usual_s)) & ~jump & ~begins
    return tuple(filter(None, (_jumps_note(jump, time_s, steps_m), gaps_note(gap, time_s, steps_m))))


def _jumps_note(jump: Flags, time_s: Floats, steps_m: Floats) -> str:
    """Where a position changed at once: what is there may never have been flown over."""
    if not jump.any():
        return ""
    told = [f"by {steps_m[i]:.0f} m at {time_s[i]:.0f} s" for i in _greatest(jump, steps_m)]
    return f"The recording jumps, faster than a vehicle flies, and the route follows: {_listed(told, jump)}."


def gaps_note(gap: Flags, time_s: Floats, steps_m: Floats) -> str:
    """A sentence on where nothing was recorded for long, though the vehicle flew.

    Args:
        gap: which of the steps from fix to fix are such (n - 1,).
        time_s: of the fixes (n,).
        steps_m: how far the steps lead (n - 1,).
    """
    if not gap.any():
        return ""
    steps_s = np.diff(time_s)
    told = [
        f"{steps_s[i]:.0f} s from {time_s[i]:.0f} s on ({steps_m[i]:.0f} m)" for i in _greatest(gap, steps_s)
    ]
    return f"The vehicle flies straight on where nothing is recorded: {_listed(told, gap)}."


def _greatest(some: Flags, sizes: Floats) -> list[int]:
    """The few of some steps that are greatest, in order."""
    found = np.flatnonzero(some)
    return sorted(found[np.argsort(-sizes[found], kind="stable")][:_MOST].tolist())


def _listed(told: list[str], some: Flags) -> str:
    """What is told of some, and how many there are besides."""
    more = int(some.sum()) - len(told)
    return ", ".join([*told, f"{more} time{'s' if more > 1 else ''} more"] if more else told)
