"""What it costs on paper to go on as another draft: by the curves of what comes of it."""

import numpy as np
import pytest

from flight_replay.geometry.arrays import Floats
from flight_replay.planning.fit.chains.curve_prices import CurvePrices
from flight_replay.planning.fit.draft import Draft
from flight_replay.planning.fit.offsets import match_to_plan
from flight_replay.planning.fit.reference import local_track
from tests.helpers.fit_tracks import along

PLACES = 9
RECORDING = local_track(along([(0.0, 0.0), (160.0, 0.0)], 4.0), 20.0)


def draft(off_m: Floats, straight: tuple[int, ...] = ()) -> Draft:
    """Splines through places every 20 m that are beside the way by ``off_m``, but for straight legs."""
    places = np.column_stack([np.linspace(0.0, 160.0, PLACES), off_m, np.full(PLACES, 20.0)])
    spline = np.arange(PLACES) > 0
    spline[list(straight)] = False
    return Draft(places, spline, np.append(1.0, np.zeros(PLACES - 1)), np.full(PLACES, np.nan))


def planned_m4(draft: Draft) -> float:
    """The means of fourth powers of distances, both ways together."""
    return float(sum((offsets.apart_m**4).mean() for offsets in match_to_plan(draft, RECORDING)))


def prices(*drafts: Draft) -> CurvePrices:
    passing_s = np.tile(np.linspace(0.0, RECORDING.time_s[-1], PLACES), len(drafts))
    return CurvePrices(RECORDING, drafts, passing_s, 1.0)


def test_going_on_as_a_draft_that_is_alike_costs_nothing() -> None:
    """Wherever that is."""
    off_m = 2.0 * np.sin(np.arange(PLACES))
    legs = np.arange(PLACES)
    assert prices(draft(off_m), draft(off_m)).prices_m(legs, PLACES + legs) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("straight", [(), (4,), (5,), (6,)])
def test_what_curves_become_costs_what_they_are_farther_off(straight: tuple[int, ...]) -> None:
    """The legs before and after the change bend to one side, those that stay as they were cost the same."""
    right, left = np.full(PLACES, 1.5), np.full(PLACES, -1.5)
    right[4] = left[4] = 0.0
    here, there = draft(right, straight), draft(left, straight)
    (price_m4,) = prices(here, there).prices_m(np.array([4]), np.array([PLACES + 4]))
    joined = draft(np.append(right[:5], left[5:]), straight)
    more_m4 = planned_m4(joined) - (planned_m4(here) + planned_m4(there)) / 2
    assert price_m4 == pytest.approx(max(more_m4, 0.0), abs=0.05)


def test_behind_the_last_place_nothing_is_left_to_cost() -> None:
    """A chain may end as another draft ends."""
    here, there = draft(np.full(PLACES, 1.0)), draft(np.full(PLACES, -1.0))
    assert prices(here, there).prices_m(np.array([8]), np.array([PLACES + 8])).tolist() == [0.0]
