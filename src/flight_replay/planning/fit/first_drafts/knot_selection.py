"""Which fixes become waypoints: too many at first, of which those that are missed least are taken away.

A waypoint is worth what the path on paper, and one speed a leg, lose without it, by the measure of
``objective``. Taking away goes on below the number that is allowed as long as next to nothing is lost.
It is line simplification from the dense end, with the curves that ArduCopter flies instead of lines.
"""

from __future__ import annotations

import heapq
from dataclasses import replace

import numpy as np

from flight_replay.geometry.hermite_curve import weights_of_steps
from flight_replay.geometry.polyline import lengths_along_m, segment_lengths_m
from flight_replay.planning.fit.draft import Draft, flown_through
from flight_replay.planning.fit.first_drafts.flyable_motion import flyable_motion
from flight_replay.planning.fit.gauss_newton import gauss_newton_step, weighted_residuals
from flight_replay.planning.fit.objective import TIME_SHARE, path_error_m
from flight_replay.planning.fit.offsets import match_to_plan
from flight_replay.planning.fit.problem import FirstDraft, FitProblem
from flight_replay.planning.fit.reference import Hover, LocalTrack, holds_s
from flight_replay.planning.fit.scalar.knot_cost import CandidateKnots, KnotCost

USUAL_CANDIDATES = 2.0
"""Candidates for each place that is kept."""
_CANDIDATES = (2.0, 4.0, 3.0, 1.5, 2.5, 3.5, 5.0)
_LONG_LEGS = ((None, 1.0, 2.0), (0.9, 0.85, 4.0), (None, 1.15, 3.0))
"""Of what several selections are made: the way, how many places of those there may be, candidates for each.

A way is the recorded one, or it is flyable with so much of the vehicle's acceleration. Stretches of a draft
with fewer places pay for those of one with more; and a fast vehicle is slowed down by short legs.
"""
_SHORT_LEG_S = 2.25
"""Legs that last less on average slow a vehicle."""
_SHORT_LEGS = ((0.8, 1.8), (0.9, 1.8), (None, 1.8), (None, 2.1))
"""The same where legs would be short: the way, and what legs last on average."""
_FEWEST = 5
_USUAL_ERROR_M = 0.4
"""Path error about which the objective is taken to be linear in the fourth powers of distances."""
_UNEVEN_SHARE = 0.2
"""What uneven speed within a leg counts of the position error that it means at one speed a leg."""
_FREE_LOSS_M = 0.0001
"""A waypoint worth less than this of the objective is not needed."""
_STEPS_A_LEG = 12
_PAPER_STEPS, _PAPER_GAIN, _PAPER_SMOOTHING = 3, 0.7, 0.003


def select_waypoints(
    problem: FitProblem, most: int, candidates_a_place: float = USUAL_CANDIDATES
) -> FirstDraft:
    """A draft of at most ``most`` splines through the recording, and the hovers that it waits for.

    Args:
        problem: its recording has at least two fixes; fewer hovers than ``most`` - 2.
        most: at least two.
        candidates_a_place: how many waypoints there are at first for each that may be kept: with others
            the same recording is followed by quite another draft.
    """
    candidates = round(candidates_a_place * most)
    knots = _Knots(problem.recording, problem.hovers, candidates, timed=problem.timed)
    knots.thin_out(most)
    kept = np.flatnonzero(knots.alive).tolist()
    hovers = {place: hover for place, knot in enumerate(kept) if (hover := knots.hover[knot]) and place > 0}
    hold_s = holds_s(len(kept), hovers, timed=problem.timed)
    level = np.full((len(kept), 3), problem.recording.up_m[0])
    places_m = np.column_stack([knots.place_m[kept], level])[:, :3]
    through = flown_through(hold_s, timed=problem.timed, straight_starts=problem.straight_starts)
    draft = Draft(places_m, through, hold_s, np.full(len(kept), np.nan))
    return FirstDraft(_moved_on_paper(draft, problem.recording), hovers)


def selections(problem: FitProblem, most: int) -> list[FirstDraft]:
    """Several drafts of about ``most`` places, the first of no more.

    They differ in what they are selected from. Where the recorded speed is to be kept, that may be a way on
    which the vehicle can keep up; and if legs would be short, which slows it, all have fewer places. Else
    one has fewer, and the last more, of which stretches are taken where they are missed most.
    """
    if not problem.timed:
        return [select_waypoints(problem, most, candidates) for candidates in _CANDIDATES]
    moving_s = float(problem.recording.time_s[-1]) - sum(hover.seconds for hover in problem.hovers)
    legs = most - len(problem.hovers)
    if moving_s >= _SHORT_LEG_S * legs:
        return [
            select_waypoints(_on_way(problem, share), round(places * most), candidates)
            for share, places, candidates in _LONG_LEGS
        ]
    found = []
    for share, leg_s in _SHORT_LEGS:
        enough = min(legs, max(_FEWEST, round(moving_s / leg_s)))
        found.append(select_waypoints(_on_way(problem, share), len(problem.hovers) + enough))
    return found


def _on_way(problem: FitProblem, share: float | None) -> FitProblem:
    """The problem with the recording as it is flyable with so much of the acceleration, or as it is."""
    if share is None:
        return problem
    way = flyable_motion(problem.recording, share * problem.limits.wp_accel_m_s2)
    return replace(problem, recording=way)


def _moved_on_paper(draft: Draft, recording: LocalTrack) -> Draft:
    """The draft with its places moved so that its planned path comes nearer to the fixes, if it does.

    Between fixes that are far apart curves swing out farther with each step.
    """
    start, moved = match_to_plan(draft, recording), draft
    found = start
    for _ in range(_PAPER_STEPS):
        residuals = weighted_residuals(moved, found, len(recording))
        moved = gauss_newton_step(moved, residuals, _PAPER_SMOOTHING, _PAPER_GAIN)
        found = match_to_plan(moved, recording, found[0].progress)
    return moved if path_error_m(found) < path_error_m(start) else draft


class _Knots:
    """Waypoints in order, each standing for the fixes ``first`` to ``last``; some are taken away."""

    def __init__(self, recording: LocalTrack, hovers: list[Hover], count: int, *, timed: bool) -> None:
        found = _candidates(recording, hovers, count)
        first, last, self.hover = (list(column) for column in zip(*found, strict=True))
        stops = [hover is not None for hover in self.hover]
        stops[0] = stops[-1] = True
        straight = [timed and hover is not None for hover in self.hover]
        fixes_m = recording.places_m
        self.place_m = np.array([fixes_m[a : b + 1].mean(axis=0) for a, b, _ in found])
        self.place_m[-1] = fixes_m[-1]
        self._cost = KnotCost(
            CandidateKnots(self.place_m.tolist(), first, last, stops, straight),
            (fixes_m.tolist(), recording.time_s.tolist(), lengths_along_m(fixes_m).tolist()),
            weights_of_steps(_STEPS_A_LEG),
            1 / (8 * _USUAL_ERROR_M**3),
            _UNEVEN_SHARE * TIME_SHARE / len(fixes_m) if timed else 0.0,
        )
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
        leg_m = self._cost.leg_m
        growth = leg_m(aa, a, b, bb) - leg_m(aa, a, knot, b) - leg_m(a, knot, b, bb)
        if aa >= 0:
            growth += leg_m(self._before[aa], aa, a, b) - leg_m(self._before[aa], aa, a, knot)
        if bb < len(self.alive):
            growth += leg_m(a, b, bb, self._after[bb]) - leg_m(knot, b, bb, self._after[bb])
        return growth


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
