"""What is tried at a place: kinds of legs, stops, and corners where the recording turns."""

import numpy as np
import pytest

from flight_replay.planning.fit.legs.leg_changes import corner_changes, kind_changes
from tests.helpers.fit_tracks import draft_of

DRAFT = draft_of([(0, 0), (28, 3), (60, 60), (60, 90)], [False, True, True, True], [1, 0, 0, 0])
FIXES_M = np.array([(20.0, 0.0), (40.0, 0.0), (59.0, 1.0), (60.0, 30.0)])


def test_a_corner_lies_where_the_recording_turns() -> None:
    """The place moves to the fix farthest from the line past it; one or both of its legs are straight."""
    changed = list(corner_changes(DRAFT, 1, {}, FIXES_M))
    assert [draft.spline.tolist() for draft in changed] == [
        [False, False, False, True],
        [False, False, True, True],
    ]
    for draft in changed:
        assert draft.places_m[1].tolist() == [59.0, 1.0, 20.0]
        assert (draft.places_m[[0, 2, 3]] == DRAFT.places_m[[0, 2, 3]]).all()


@pytest.mark.parametrize(
    ("place", "hovers", "fixes"), [(3, set(), 4), (1, {1}, 4), (1, set(), 0)], ids=["last", "hover", "no fix"]
)
def test_no_corner_where_none_can_be(place: int, hovers: set[int], fixes: int) -> None:
    """At the end, where the vehicle waits anyway, and where nothing was recorded."""
    assert not list(corner_changes(DRAFT, place, hovers, FIXES_M[:fixes]))


def test_kinds_are_changed_one_at_a_time() -> None:
    """Curved or straight, stopped at, and the leg behind straight; a hover stays."""
    straight, stopped, behind = kind_changes(DRAFT, 1, set(), straight_starts=False)
    assert straight.spline.tolist() == [False, False, True, True]
    assert stopped.hold_s[1] > 0
    assert not stopped.spline[1]
    assert behind.spline.tolist() == [False, False, False, True]
    assert not list(kind_changes(DRAFT, 1, {1}, straight_starts=False))
