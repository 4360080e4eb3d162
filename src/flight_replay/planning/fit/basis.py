"""How a planned path moves when its places move: every point of a leg is a weighted sum of places."""

from __future__ import annotations

import numpy as np

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.mission.path import TANGENT_PER_CHORD
from flight_replay.planning.fit.draft import Draft


def weights(draft: Draft, leg: Indices, part: Floats) -> Floats:
    """Weights (m, n) of the n places on the points ``part`` of the way along the legs to places ``leg``.

    Straight legs are linear in their ends; a spline leg is a Hermite curve whose tangents are
    differences of places (see ``path``). Tangents that are scaled down stay scaled alike.
    """
    rows = np.zeros((len(leg), len(draft)))
    index = np.arange(len(leg))
    origin = np.maximum(leg - 1, 0)
    u = np.where(leg == 0, 1.0, part)
    curved = draft.spline[leg] & (leg > 0)
    end = np.where(curved, u * u * (3 - 2 * u), u)
    np.add.at(rows, (index, origin), 1 - end)
    np.add.at(rows, (index, leg), end)
    leaving, arriving, scale = _tangents(draft)
    rise = np.where(curved, u * (1 - u) ** 2, 0.0) * scale[leg]
    fall = np.where(curved, u * u * (u - 1), 0.0) * scale[leg]
    for share, pair in ((rise, leaving), (fall, arriving)):
        np.add.at(rows, (index, pair[leg, 0]), share)
        np.add.at(rows, (index, pair[leg, 1]), -share)
    return rows


def _tangents(draft: Draft) -> tuple[Indices, Indices, Floats]:
    """For every leg the places (head, tail) whose differences are its tangents, and their scale.

    A tangent of zero has head and tail alike.
    """
    n = len(draft)
    here = np.arange(n)
    before, after = np.maximum(here - 1, 0), np.minimum(here + 1, n - 1)
    spline = draft.spline
    bends = spline & spline[after]
    arriving = np.stack([after, np.where(bends, before, here)], axis=1)
    arriving[~spline] = np.stack([here, before], axis=1)[~spline]
    arriving[draft.halts] = 0
    leaving = np.concatenate([np.zeros((1, 2), np.intp), arriving[:-1]])
    places = draft.places_m
    together = sum(
        np.linalg.norm(places[pair[:, 0]] - places[pair[:, 1]], axis=1) for pair in (leaving, arriving)
    )
    longest = TANGENT_PER_CHORD * np.linalg.norm(places - places[before], axis=1)
    return leaving, arriving, np.where(together > longest, longest / np.maximum(together, 1e-9), 1.0)
