"""Moving the places of a draft so that its path comes nearer to the recording: one Gauss-Newton step."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.planning.fit.basis import weights
from flight_replay.planning.fit.draft import Draft

ALONG_SHARE = 0.05
"""How much a place resists sliding along the path, against moving across it."""
_STILL = 0.01
_LONGEST_STEP_M = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class Pull:
    """Points of the path, ``part`` of the way along the legs ``leg``, drawn along ``off_m`` (m, 2).

    ``ahead`` (m, 2) are unit vectors along the path there, ``weight`` (m,) how strongly each pulls.
    """

    leg: Indices
    part: Floats
    ahead: Floats
    off_m: Floats
    weight: Floats


def pulled(draft: Draft, pulls: list[Pull], bend: Floats | float, gain: float = 1.0) -> Draft:
    """The draft whose inner places answer the pulls in the least-squares sense; the ends stay.

    Args:
        draft: at least two places.
        pulls: what draws where.
        bend: weight against unevenness, the third differences of the places (n - 3,).
        gain: share of the step that is taken.
    """
    n = len(draft)
    if n < 3:
        return draft
    third = np.diff(np.eye(n), 3, axis=0)
    smooth = third.T @ (np.broadcast_to(bend, len(third))[:, None] * third)
    normal = np.kron(np.eye(2), smooth + _STILL * np.eye(n))
    force = -(smooth @ draft.places_m[:, :2]).T.ravel()
    for pull in pulls:
        rows = weights(draft, pull.leg, pull.part)
        across, along = pull.weight, pull.weight * ALONG_SHARE
        keep = (along - across)[:, None] * pull.ahead
        metric = keep[:, :, None] * pull.ahead[:, None, :] + across[:, None, None] * np.eye(2)
        blocks = [[rows.T @ (metric[:, i, j, None] * rows) for j in (0, 1)] for i in (0, 1)]
        normal += np.block(blocks)
        force += (rows.T @ (metric @ pull.off_m[:, :, None])[:, :, 0]).T.ravel()
    free = np.tile(np.arange(n) % (n - 1) != 0, 2)
    step = np.zeros(2 * n)
    step[free] = np.linalg.solve(normal[np.ix_(free, free)], force[free])
    return _stepped(draft, gain * step.reshape(2, n).T)


def _stepped(draft: Draft, step_m: Floats) -> Draft:
    size = np.linalg.norm(step_m, axis=1, keepdims=True)
    places = draft.places_m.copy()
    places[:, :2] += step_m * np.minimum(1.0, _LONGEST_STEP_M / np.maximum(size, 1e-9))
    return replace(draft, places_m=places)


def raised(draft: Draft, leg: Indices, part: Floats, up_m: Floats) -> Draft:
    """The draft with the heights that follow ``up_m`` (m,) best at the given points of its path.

    No place is higher or lower than the recording is anywhere.
    """
    rows = weights(draft, leg, part)
    second = np.diff(np.eye(len(draft)), 2, axis=0)
    normal = rows.T @ rows + _STILL * (np.eye(len(draft)) + second.T @ second)
    start = draft.places_m[:, 2]
    height = start + np.linalg.solve(normal, rows.T @ (up_m - rows @ start))
    places = draft.places_m.copy()
    places[:, 2] = np.clip(height, up_m.min(), up_m.max())
    return replace(draft, places_m=places)
