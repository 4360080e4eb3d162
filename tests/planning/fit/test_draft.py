"""Routes while they are fitted: what is asked of their legs, whatever a search would like."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.planning.fit.draft import Draft, with_straight_climbs, without_hooks
from flight_replay.planning.fit.reference import flat_frame
from flight_replay.planning.fit.simulated_draft import simulate_draft
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import along, draft_of

BEHIND_A_STOP: list[tuple[float, float]] = [(0, 0), (20, 0), (25, 0), (49, 4), (70, 0)]
CURVES = [False, False, True, True, True]


def backs_up_m(draft: Draft) -> float:
    """How far the vehicle flies back from the stop at (20, 0)."""
    flown = simulate_draft(draft, Limits(), 0.02)
    return 20.0 - float(flown.place_m[flown.time_s > flown.passed_s[1], 0].min())


def test_no_curve_begins_backwards_from_a_stop() -> None:
    """A short curve from a stop, a long one after it, would back up first: its leg becomes straight."""
    draft = draft_of(BEHIND_A_STOP, CURVES, [1, 8, 0, 0, 0])
    straight = without_hooks(draft)
    assert straight.spline.tolist() == [False, False, False, True, True]
    assert backs_up_m(draft) > 0.1
    assert backs_up_m(straight) < 0.02


@pytest.mark.parametrize(
    ("places", "hold"),
    [
        (BEHIND_A_STOP, [1, 0, 0, 0, 0]),
        (BEHIND_A_STOP, [1, 8, 1, 0, 0]),
        ([(0, 0), (20, 0), (25, 0), (33, 2), (50, 0)], [1, 8, 0, 0, 0]),
        ([(0, 0), (20, 0), (40, 0)], [1, 8, 0]),
        ([(0, 0), (20, 0)], [1, 0]),
    ],
)
def test_other_curves_stay(places: list[tuple[float, float]], hold: list[float]) -> None:
    """Where the vehicle flies through, or stops at the end, where legs are alike, and the last."""
    curves = CURVES[: len(places)]
    assert np.array_equal(without_hooks(draft_of(places, curves, hold)).spline, curves)


def test_straight_up_and_down_and_to_there_and_from_there_but_for_a_stop() -> None:
    """Level, down and on from a stop, level again; a draft without steep legs is itself."""
    places: list[tuple[float, float]] = [(0, 0), (20, 0), (40, 0), (40, 1), (60, 0), (80, 0)]
    draft = draft_of(places, [False, True, True, True, True, True], [1, 0, 0, 0, 0, 0])
    assert with_straight_climbs(draft) is draft
    draft.places_m[3:, 2] -= 15.0
    assert with_straight_climbs(draft).spline.tolist() == [False, True, False, False, False, True]
    stopping = replace(draft, hold_s=np.array([1.0, 0, 2, 3, 0, 0]))
    assert with_straight_climbs(stopping).spline.tolist() == [False, True, True, False, True, True]


def test_places_are_where_items_hold_them() -> None:
    """They come back from the mission as they are, a centimetre from where they were; once is enough."""
    frame = flat_frame(along([(0, 0), (40, 0)], 4.0))
    draft = draft_of([(0, 0), (20.0051, 3.0049), (40, -7.123456)], [False, True, False], [1, 0, 0])
    held = draft.as_items_hold_it(frame)
    items = [item for _, item in held.mission(frame, Limits()).waypoints]
    lat, lon = ([round(getattr(item, each), 7) for item in items] for each in ("lat_deg", "lon_deg"))
    assert held.places_m[:, :2] == pytest.approx(frame.to_metres(lat, lon), abs=1e-6)
    assert 0 < np.abs(held.places_m - draft.places_m).max() < 0.01
    assert held.as_items_hold_it(frame) is held
