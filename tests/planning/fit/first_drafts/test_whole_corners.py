"""Corners that a vehicle cut as it flew through them."""

import numpy as np
import pytest

from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.first_drafts.whole_corners import with_whole_corners
from flight_replay.planning.fit.problem import FirstDraft
from flight_replay.planning.fit.reference import Hover
from tests.helpers.fit_tracks import draft_of

Places = list[tuple[float, float]]
PAUSE = Hover(30, 40, 5.0)


def places(draft: Draft) -> list[tuple[float, float]]:
    return [(north, east) for north, east, _ in draft.places_m.round(6).tolist()]


def test_a_curve_between_two_long_legs_becomes_the_corner_in_which_they_meet() -> None:
    """What comes after has another number then, and so has the pause at it."""
    around: Places = [(0, 0), (36, 0), (38, 1), (40, 4), (40, 30), (40, 60)]
    draft = draft_of(around, [False, False, True, True, False, False], [6, 0, 0, 0, 4, 0])
    whole = with_whole_corners(FirstDraft(draft, {4: PAUSE}))
    assert places(whole.draft) == [(0, 0), (40, 0), (40, 30), (40, 60)]
    assert whole.hovers == {2: PAUSE}
    assert whole.draft.hold_s.tolist() == [6, 0, 4, 0]
    assert not whole.draft.spline.any()


def test_corners_one_after_another_become_whole() -> None:
    """A leg between two of them goes on both ways."""
    square: Places = [(0, 0), (37, 0), (40, 3), (40, 37), (37, 40), (3, 40)]
    straight = [False, False, True, False, True, False]
    start = FirstDraft(draft_of(square, straight, [6, 0, 0, 0, 0, 0]), {})
    assert places(with_whole_corners(start).draft) == [(0, 0), (40, 0), (40, 40), (3, 40)]


@pytest.mark.parametrize(
    "around",
    [
        [(0, 0), (36, 0), (38, 1), (60, 1.5), (80, 2)],  # they run beside each other
        [(0, 0), (36, 0), (36, 8), (0, 16)],  # they meet behind where they begin
        [(0, 0), (30, 0), (34, 4), (60, 8), (90, 12)],  # they would meet too far away
        [(0, 0), (40, 0), (40, 30), (70, 30)],  # a corner is one already
    ],
)
def test_other_curves_stay(around: Places) -> None:
    """Where lines do not meet near a curve's ends, it is none that was cut."""
    n = len(around)
    start = FirstDraft(draft_of(around, [False] * n, [6.0] + [0.0] * (n - 1)), {})
    assert places(with_whole_corners(start).draft) == around


def test_a_wait_within_a_curve_stays() -> None:
    """The recorded vehicle was there."""
    around: Places = [(0, 0), (36, 0), (38, 1), (40, 4), (40, 30)]
    draft = draft_of(around, [False, False, True, True, False], [6, 0, 3, 0, 0])
    assert len(with_whole_corners(FirstDraft(draft, {2: PAUSE})).draft) == 5


def test_a_corner_is_as_high_as_its_curve() -> None:
    """Heights are those of the recording, where they are followed."""
    draft = draft_of([(0, 0), (36, 0), (40, 4), (40, 30)], [False, False, True, False], [6, 0, 0, 0])
    draft.places_m[:, 2] = [10.0, 14.0, 16.0, 20.0]
    assert with_whole_corners(FirstDraft(draft, {})).draft.places_m[:, 2].tolist() == [10.0, 15.0, 20.0]
    assert np.isnan(draft.speed_m_s).all()


def test_a_climb_on_the_spot_meets_no_line() -> None:
    """It has no way over the ground."""
    around: Places = [(0, 0), (30, 0), (30, 0), (30, 0), (60, 0)]
    draft = draft_of(around, [False] * 5, [6, 0, 0, 0, 0])
    draft.places_m[:, 2] = [10.0, 10.0, 50.0, 10.0, 10.0]
    assert places(with_whole_corners(FirstDraft(draft, {})).draft) == around
