"""How a planned path moves when its places move: every point of a leg is a weighted sum of places."""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.geometry.hermite_curve import curve_weights, tangent_scale
from flight_replay.mission.path import tangent_ends
from flight_replay.planning.fit.draft import Draft


def weights(draft: Draft, leg: Indices, part: Floats) -> Floats:
    """Weights (m, n) of the n places on the points ``part`` of the way along the legs to places ``leg``."""
    places, share = shares(draft, leg, part)
    rows = np.zeros((len(leg), len(draft)))
    np.add.at(rows, (np.arange(len(leg))[:, None], places), share)
    return rows


def shares(draft: Draft, leg: Indices, part: Floats) -> tuple[Indices, Floats]:
    """The places (m, 6) that points are weighted sums of, and their weights (m, 6), none but those.

    Straight legs are linear in their ends; a spline leg is a Hermite curve whose tangents are
    differences of places (see ``mission.path``). Tangents that are scaled down stay scaled alike.
    """
    t = np.where(leg == 0, 1.0, part)
    straight = np.stack([1 - t, t, np.zeros_like(t), np.zeros_like(t)], axis=1)
    curved = draft.spline[leg] & (leg > 0)
    share = np.where(curved[:, None], curve_weights(t), straight)
    (leaving_head, leaving_tail), (arriving_head, arriving_tail), scale = _tangents(draft)
    leaving, arriving = share[:, 2] * scale[leg], share[:, 3] * scale[leg]
    ends = leaving_head[leg], leaving_tail[leg], arriving_head[leg], arriving_tail[leg]
    places = np.stack([np.maximum(leg - 1, 0), leg, *ends], axis=1)
    return places, np.stack([share[:, 0], share[:, 1], leaving, -leaving, arriving, -arriving], axis=1)


def _tangents(draft: Draft) -> tuple[tuple[Indices, Indices], tuple[Indices, Indices], Floats]:
    """For every leg the places (head, tail) whose differences are its tangents, and their scale."""
    places = draft.places_m
    chord = np.diff(places, axis=0, prepend=places[:1])
    # The first leg leads from the first place to itself: corner k + 1 of the path is place k.
    leaving, arriving = (
        (np.maximum(head - 1, 0), np.maximum(tail - 1, 0))
        for head, tail in tangent_ends(draft.spline, draft.halts, np.logical_not(chord.any(axis=1)))
    )
    scale = tangent_scale(chord, *(places[head] - places[tail] for head, tail in (leaving, arriving)))
    return leaving, arriving, scale
