"""What made a step late is learned, and foretold the next time."""

import numpy as np
import pytest

from flight_replay.planning.fit.fit import problem_for
from flight_replay.planning.fit.legs.flight_derivatives import FlightDerivatives
from flight_replay.planning.fit.reference import local_track
from flight_replay.planning.fit.steps.delays import Delays
from flight_replay.planning.fit.steps.linear_model import Sides
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import along, draft_of

PLACES = np.repeat(np.arange(1, 8), 2)
USUAL = np.full(len(PLACES), 0.4)
LATE_S = np.array([0.0, 0.0, 0.0, 0.5, 0.5, 0.25, 0.25, 0.25])
"""Half a second came on the leg to place 3, half of which was made up on that to place 5."""


def step(*sizes: tuple[int, float]) -> np.ndarray:
    changes = np.zeros(len(PLACES))
    for change, size in sizes:
        changes[change] = size
    return changes


def test_the_same_step_is_late_by_what_it_was_late_by() -> None:
    """And one as long to the other side."""
    changes = step((4, 0.2), (5, -0.1), (13, 0.3))
    delays = Delays.none(8, len(PLACES)).learned(changes, USUAL, PLACES, LATE_S)
    assert delays.are_known
    assert delays.by_change @ np.abs(changes) == pytest.approx(LATE_S)


def test_changes_far_from_where_it_came_are_not_to_blame() -> None:
    """Those of the places that shape the leg are, by how large they were, and no others."""
    changes = step((4, 0.2), (5, -0.1), (13, 0.3))
    by_change = Delays.none(8, len(PLACES)).learned(changes, USUAL, PLACES, LATE_S).by_change
    assert np.flatnonzero(by_change.any(axis=0)).tolist() == [4, 5]
    assert by_change[:, 4] == pytest.approx(by_change[:, 5])


def test_what_is_learned_adds_up() -> None:
    """Of two steps both are known; of one that was on time nothing."""
    none = Delays.none(8, len(PLACES))
    once = none.learned(step((4, 0.2)), USUAL, PLACES, LATE_S)
    twice = once.learned(step((4, 0.2)), USUAL, PLACES, LATE_S)
    assert twice.by_change == pytest.approx(2 * once.by_change)
    assert not none.learned(step((4, 0.2)), USUAL, PLACES, -LATE_S).are_known
    assert not none.learned(step((13, 0.2)), USUAL, PLACES, LATE_S).are_known


def test_the_vehicle_is_farther_back_by_how_much_later_it_is() -> None:
    """At 4 m/s and half a second two metres, from the leg on; nothing else changes, to neither side."""
    recording = local_track(along([(0, 0), (280, 0)], 4.0), 20.0)
    problem = problem_for(recording, 20, Limits(), timed=True)
    draft = draft_of([(40.0 * i, 0.0) for i in range(8)], [False] * 8, [0] * 8)
    base, fixes = problem.evaluate(draft), len(problem.recording)
    at_fixes, beside = np.ones((2 * fixes, len(PLACES))), np.ones((4 * fixes, len(PLACES)))
    sides = Sides(FlightDerivatives(at_fixes, beside, np.zeros((8, len(PLACES))), 0))
    late_s, changes = np.where(np.arange(8) < 3, 0.0, 0.5), step((4, 0.2))
    delays = Delays.none(8, len(PLACES)).learned(changes, USUAL, PLACES, late_s)
    now = delays.added_to(sides, base, problem.recording)
    for way in (1.0, -1.0):
        moved_m = (now.errors(way * changes) - sides.errors(way * changes)).reshape(-1, 2)
        before, after = np.searchsorted(problem.recording.time_s, [base.passed_s[2], base.passed_s[3]])
        flying = problem.recording.time_s < base.passed_s[-1] - 5.0
        assert not moved_m[:before].any()
        assert not moved_m[fixes:].any()
        speed_m_s = (base.passed_s[6] - base.passed_s[4]) / 80.0
        assert moved_m[after:fixes][flying[after:], 0] == pytest.approx(-0.5 / speed_m_s, rel=0.05)
        assert now.passed_s(way * changes) == pytest.approx(late_s)
    assert Delays.none(8, len(PLACES)).added_to(sides, base, problem.recording) is sides


def test_a_change_of_nothing_is_not_to_blame() -> None:
    """What were learned from it would be so large that no equation with it can be solved."""
    assert not Delays.none(8, len(PLACES)).learned(step((4, 1e-20)), USUAL, PLACES, LATE_S).are_known
