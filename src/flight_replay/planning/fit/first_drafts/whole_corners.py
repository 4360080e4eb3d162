"""Corners of missions that were flown through: a vehicle cuts them, so that they lie beside its way."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.polyline import segment_lengths_m
from flight_replay.planning.fit.first_drafts.line_simplification import LONG_M
from flight_replay.planning.fit.problem import FirstDraft

_FARTHEST_M = 20.0
"""Corners are cut from no farther: in so much ArduCopter comes to rest from 10 m/s, at 2.5 m/s²."""
_LEAST_SINE = 0.1
"""Lines that turn less into each other may meet anywhere."""


def with_whole_corners(start: FirstDraft) -> FirstDraft:
    """A draft in which long straight legs go on to where they meet, instead of a curve between them.

    Args:
        start: its long legs are straight; see ``corner_draft``.
    """
    draft = start.draft
    places_m, kept = draft.places_m.copy(), np.ones(len(draft), np.bool_)
    long_legs = np.flatnonzero(segment_lengths_m(draft.places_m) >= LONG_M)
    for leg, next_leg in pairwise(long_legs.tolist()):
        first, last = leg + 1, next_leg
        corner_m = _meeting_m(draft.places_m[[leg, first, last, last + 1], :2])
        if first < last and corner_m is not None and not draft.hold_s[first : last + 1].any():
            places_m[first] = *corner_m, draft.places_m[first : last + 1, 2].mean()
            kept[first + 1 : last + 1] = False
    waits = {int(kept[:place].sum()): hover for place, hover in start.hovers.items()}
    return FirstDraft(replace(draft, places_m=places_m).select(kept), waits)


def _meeting_m(places_m: Floats) -> Floats | None:
    """Where the line from the first to the second of four places meets that from the fourth to the third.

    It is not far behind those two, if there is one.
    """
    origins, ways = places_m[[0, 3]], np.diff(places_m, axis=0)[[0, 2]] * [[1.0], [-1.0]]
    lengths_m = np.linalg.norm(ways, axis=1)
    if not lengths_m.all():  # A climb on the spot has no way.
        return None
    ways = ways / lengths_m[:, np.newaxis]
    columns = np.column_stack([ways[0], -ways[1]])
    if abs(np.linalg.det(columns)) < _LEAST_SINE:
        return None
    beyond_m = np.linalg.solve(columns, origins[1] - origins[0]) - lengths_m
    if (beyond_m < 0).any() or (beyond_m > _FARTHEST_M).any():
        return None
    return np.asarray(origins[0] + (lengths_m[0] + beyond_m[0]) * ways[0])
