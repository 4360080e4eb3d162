"""Which fixes become waypoints: too many at first, of which those that are missed least are taken away.

A waypoint is worth what the path on paper, and one speed a leg, lose without it, by the measure of
``objective``. Taking away goes on below the number that is allowed as long as next to nothing is lost.
It is line simplification from the dense end, with the curves that ArduCopter flies instead of lines.
"""

from __future__ import annotations

import heapq

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.hermite_curve import curve_weights, tangent_scale
from flight_replay.geometry.polyline import lengths_along_m, nearest_on_segments, segment_lengths_m
from flight_replay.planning.fit.draft import Draft, flown_through
from flight_replay.planning.fit.gauss_newton import gauss_newton_step, weighted_residuals
from flight_replay.planning.fit.objective import TIME_SHARE, match_to_plan
from flight_replay.planning.fit.problem import FirstDraft, FitProblem
from flight_replay.planning.fit.reference import Hover, LocalTrack, holds_s

CANDIDATES_A_PLACE = 2
_USUAL_ERROR_M = 0.4
"""Path error about which the objective is taken to be linear in the fourth powers of distances."""
_UNEVEN_SHARE = 0.2
"""What uneven speed within a leg counts of the position error that it means at one speed a leg."""
_FREE_LOSS_M = 0.0001
"""A waypoint worth less than this of the objective is not needed."""
_AROUND_FIXES = 2
_WEIGHTS = curve_weights(np.linspace(0.0, 1.0, 13))
_PAPER_STEPS, _PAPER_GAIN, _PAPER_SMOOTHING = 3, 0.7, 0.003


def select_waypoints(problem: FitProblem, most: int) -> FirstDraft:
    """A draft of at most ``most`` splines through the recording, and the hovers that it waits for.

    Args:
        problem: its recording has at least two fixes; fewer hovers than ``most`` - 2.
        most: at least two.
    """
    knots = _Knots(problem.recording, problem.hovers, CANDIDATES_A_PLACE * most, timed=problem.timed)
    knots.thin_out(most)
    kept = np.flatnonzero(knots.alive).tolist()
    hovers = {place: hover for place, knot in enumerate(kept) if (hover := knots.hover[knot]) and place > 0}
    hold_s = holds_s(len(kept), hovers)
    level = np.full((len(kept), 3), problem.recording.up_m[0])
    places_m = np.column_stack([knots.place_m[kept], level])[:, :3]
    through = flown_through(hold_s, timed=problem.timed, straight_starts=problem.straight_starts)
    draft = Draft(places_m, through, hold_s, np.full(len(kept), np.nan))
    return FirstDraft(_moved_on_paper(draft, problem.recording), hovers)


def _moved_on_paper(draft: Draft, recording: LocalTrack) -> Draft:
    """The draft with its places moved so that its planned path comes nearer to the fixes."""
    for _ in range(_PAPER_STEPS):
        residuals = weighted_residuals(draft, match_to_plan(draft, recording), len(recording))
        draft = gauss_newton_step(draft, residuals, _PAPER_SMOOTHING, _PAPER_GAIN)
    return draft


class _Knots:
    """Waypoints in order, each standing for the fixes ``first`` to ``last``; some are taken away."""

    def __init__(self, recording: LocalTrack, hovers: list[Hover], count: int, *, timed: bool) -> None:
        self._fixes_m, self._time_s, self._timed = recording.places_m, recording.time_s, timed
        self._along_m = lengths_along_m(self._fixes_m)
        found = _candidates(recording, hovers, count)
        self.first, self.last, self.hover = (list(column) for column in zip(*found, strict=True))
        self._stops = [hover is not None for hover in self.hover]
        self._stops[0] = self._stops[-1] = True
        self._straight = [timed and hover is not None for hover in self.hover]
        self.place_m = np.array([self._fixes_m[a : b + 1].mean(axis=0) for a, b, _ in found])
        self.place_m[-1] = self._fixes_m[-1]
        self._before, self._after = list(range(-1, len(found) - 1)), list(range(1, len(found) + 1))
        self.alive = np.ones(len(found), np.bool_)

    def thin_out(self, most: int) -> None:
        """Take away what is least missed, down to ``most``, and further while nothing is lost."""
        count = len(self.alive)
        latest = [0] * count
        queue: list[tuple[float, int, int]] = []
        for knot in range(count):
            self._enter(queue, latest, knot)
        left = count
        while queue:
            loss, knot, entry = heapq.heappop(queue)
            if not self.alive[knot] or entry != latest[knot]:
                continue
            if left <= most and loss > _FREE_LOSS_M:
                return
            before, after = self._before[knot], self._after[knot]
            self._after[before], self._before[after] = after, before
            self.alive[knot] = False
            left -= 1
            for neighbour in (self._before[before], before, after, self._after[after]):
                self._enter(queue, latest, neighbour)

    def _enter(self, queue: list[tuple[float, int, int]], latest: list[int], knot: int) -> None:
        """Enter what a knot is worth now; ends and hovers stay."""
        if 0 < knot < len(self.alive) - 1 and self.alive[knot] and self.hover[knot] is None:
            latest[knot] += 1
            heapq.heappush(queue, (self._loss_m(knot), knot, latest[knot]))

    def _loss_m(self, knot: int) -> float:
        """How much the objective grows without a knot: four legs become three."""
        a, b = self._before[knot], self._after[knot]
        aa, bb = self._before[a], self._after[b]
        growth = self._cost_m(aa, a, b, bb) - self._cost_m(aa, a, knot, b) - self._cost_m(a, knot, b, bb)
        if aa >= 0:
            growth += self._cost_m(self._before[aa], aa, a, b) - self._cost_m(self._before[aa], aa, a, knot)
        if bb < len(self.alive):
            growth += self._cost_m(a, b, bb, self._after[bb]) - self._cost_m(knot, b, bb, self._after[bb])
        return growth

    def _cost_m(self, before: int, a: int, b: int, after: int) -> float:
        """What the leg from knot a to b costs, with the knots before and after it."""
        line_m = self._curve_m(before, a, b, after)
        begin, end = self.last[a], self.first[b]
        fixes = self._fixes_m[begin : end + 1]
        there = nearest_on_segments(fixes[1:, None], line_m[:-1], np.diff(line_m, axis=0))[1]
        near = self._fixes_m[max(0, begin - _AROUND_FIXES) : end + _AROUND_FIXES + 1]
        back = nearest_on_segments(line_m[:, None], near[:-1], np.diff(near, axis=0))[1]
        powers = back.min(axis=1) ** 4
        cost = (
            float((there.min(axis=1, initial=np.inf) ** 4).sum()) / len(self._fixes_m) if end > begin else 0.0
        )
        lengths = segment_lengths_m(line_m)
        cost += float(((powers[1:] + powers[:-1]) / 2 * lengths).sum()) / max(self._along_m[-1], 1e-6)
        return float(cost / (8 * _USUAL_ERROR_M**3)) + self._uneven_m(begin, end)

    def _curve_m(self, before: int, a: int, b: int, after: int) -> Floats:
        """The leg's curve (13, axes); see ``mission.path`` for its tangents."""
        place, chord = self.place_m, self.place_m[b] - self.place_m[a]
        none = np.zeros_like(chord)
        if self._straight[b]:
            return np.asarray(place[a] + np.linspace(0.0, 1.0, len(_WEIGHTS))[:, None] * chord)
        leaving = none if self._stops[a] else place[b] - place[before]
        arriving = none if self._stops[b] else place[after] - place[b if self._straight[after] else a]
        scale = tangent_scale(chord[None], leaving[None], arriving[None])[0]
        return np.asarray(_WEIGHTS @ np.array([place[a], place[b], scale * leaving, scale * arriving]))

    def _uneven_m(self, begin: int, end: int) -> float:
        """What it costs to fly from one fix to another at one speed."""
        if not self._timed or end <= begin:
            return 0.0
        share = (self._time_s[begin : end + 1] - self._time_s[begin]) / max(
            self._time_s[end] - self._time_s[begin], 1e-6
        )
        flown = self._along_m[begin : end + 1] - self._along_m[begin]
        late_m = float(np.abs(share * flown[-1] - flown).sum())
        return _UNEVEN_SHARE * TIME_SHARE * late_m / len(self._fixes_m)


def _candidates(
    recording: LocalTrack, hovers: list[Hover], count: int
) -> list[tuple[int, int, Hover | None]]:
    """(first fix, last fix, hover) of the first waypoints: even in length and time, and the hovers."""
    steps, waits = segment_lengths_m(recording.places_m), np.diff(recording.time_s)
    for hover in hovers:
        steps[hover.first : hover.last] = waits[hover.first : hover.last] = 0.0
    share = steps / max(steps.sum(), 1e-9) + waits / max(waits.sum(), 1e-9)
    progress = np.append(0.0, np.cumsum(share))
    even = np.searchsorted(progress, np.linspace(0.0, progress[-1], count))
    last = len(recording) - 1
    kept = {0, last} | set(np.clip(even, 0, last).tolist())
    for hover in hovers:
        kept -= set(range(max(hover.first, 1), hover.last + 1))
    found: list[tuple[int, int, Hover | None]] = [(fix, fix, None) for fix in kept]
    found += [(hover.first, hover.last, hover) for hover in hovers]
    return sorted(found, key=lambda each: each[:2])
