"""Which parts of the recording get how many of the waypoints: the first draft of a route.

Waypoints stand closer where a draft with evenly spread ones misses the recording most. Hovers get one each.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.polyline import segment_lengths_m
from flight_replay.planning.fit.basis import weights
from flight_replay.planning.fit.draft import Draft, flown_through
from flight_replay.planning.fit.gauss_newton import Residuals, gauss_newton_step
from flight_replay.planning.fit.offsets import directions, match_to_plan
from flight_replay.planning.fit.reference import SETTLE_HOLD_S, Hover, LocalTrack

ROUNDS = 4
FIRST_SMOOTHING = 0.001
"""Weight against unevenness in the first draft; the search weighs it anew."""
_TIME_MIX = 0.8
_EAGERNESS = 0.2
_LEAST_ERROR_SHARE = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class _Progress:
    """Share (n,) of the recording up to every fix, part length and part time; hovers make none."""

    recording: LocalTrack
    share: Floats
    hovers: list[Hover]

    @classmethod
    def of(cls, recording: LocalTrack, hovers: list[Hover]) -> _Progress:
        steps = segment_lengths_m(recording.places_m)
        waits = np.diff(recording.time_s)
        for hover in hovers:
            steps[hover.first : hover.last] = waits[hover.first : hover.last] = 0.0
        length, time = steps / max(steps.sum(), 1e-9), waits / max(waits.sum(), 1e-9)
        share = (1 - _TIME_MIX) * length + _TIME_MIX * time
        return cls(recording, np.append(0.0, np.cumsum(share)), hovers)


def first_draft(recording: LocalTrack, places: int, hovers: list[Hover]) -> Draft:
    """A route of at most ``places`` splines through the recording, denser where it is harder to follow.

    Args:
        recording: at least two fixes.
        places: at least two.
        hovers: where to wait; fewer than ``places`` - 2.
    """
    progress = _Progress.of(recording, hovers)
    fixed = np.array([progress.share[hover.first] for hover in hovers])
    free = np.linspace(0.0, progress.share[-1], max(2, places - len(hovers)))
    best: tuple[float, Draft] | None = None
    for _ in range(ROUNDS):
        draft, knots = _drafted(progress, free, fixed)
        draft, error = _moved_to_fixes(draft, progress.recording)
        score = float(np.sqrt((error**2).mean()))
        if best is None or score < best[0]:
            best = score, draft
        free = _respaced(len(free), knots, progress, error)
    assert best is not None, "there are rounds"
    return best[1]


def _drafted(progress: _Progress, free: Floats, fixed: Floats) -> tuple[Draft, Floats]:
    """Least-squares places for knots at given progress; returns them with the knots' progress."""
    order = np.argsort(np.append(free, fixed), kind="stable")
    knots = np.append(free, fixed)[order]
    waits_s = [max(1.0, round(hover.seconds)) for hover in progress.hovers]
    waits = np.append(np.zeros(len(free)), waits_s)[order]
    waits[0] = SETTLE_HOLD_S
    recording, n = progress.recording, len(knots)
    columns = [*recording.north_east_m.T, recording.up_m]
    places = np.column_stack([np.interp(knots, progress.share, column) for column in columns])
    draft = Draft(places, flown_through(waits), waits, np.full(n, np.nan))
    leg = np.clip(np.searchsorted(knots, progress.share), 1, n - 1)
    length = knots[leg] - knots[leg - 1]
    part = np.where(length > 0, (progress.share - knots[leg - 1]) / np.maximum(length, 1e-12), 1.0)
    off = recording.north_east_m - weights(draft, leg, part) @ places[:, :2]
    residual = Residuals(leg, part, np.zeros_like(off), off, np.ones(len(off)))
    return gauss_newton_step(draft, [residual], FIRST_SMOOTHING), knots


def _moved_to_fixes(draft: Draft, recording: LocalTrack) -> tuple[Draft, Floats]:
    """The draft moved towards the fixes beside its path, and the error (n,) that remains at each fix."""
    for _ in range(2):
        there, _ = match_to_plan(draft, recording)
        residuals = [
            Residuals(there.leg, there.part, directions(draft, there), there.off_m, np.ones(len(recording)))
        ]
        draft = gauss_newton_step(draft, residuals, FIRST_SMOOTHING)
    there, _ = match_to_plan(draft, recording)
    return draft, there.apart_m


def _respaced(count: int, knots: Floats, progress: _Progress, error: Floats) -> Floats:
    """Progress of ``count`` knots moved to where the error is: demand grows with a power of it."""
    leg = np.clip(np.searchsorted(knots, progress.share), 1, len(knots) - 1)
    fixes = np.maximum(np.bincount(leg, minlength=len(knots)), 1)
    mean = np.sqrt(np.bincount(leg, error**2, minlength=len(knots)) / fixes)[1:]
    smooth = np.convolve(np.pad(mean, 1, mode="edge"), [0.25, 0.5, 0.25], "valid")
    demand = (smooth / max(smooth.mean(), 1e-9) + _LEAST_ERROR_SHARE) ** _EAGERNESS
    total = np.append(0.0, np.cumsum(np.where(np.diff(knots) > 0, demand, 0.0)))
    return np.interp(np.linspace(0.0, total[-1], count), total, knots)
