"""Drafts flown in the model."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.planning.fit.reference import Takeoff
from flight_replay.planning.fit.simulated_draft import (
    copter_after_takeoff,
    items_changed,
    items_of,
    simulate_draft,
)
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.flight.trajectory import simulate
from tests.helpers.fit_tracks import DIVE, FRAME, draft_of

DRAFT = draft_of([(0, 0), (30, 0), (60, 10), (90, 0)], [False, True, True, True], [1, 0, 0, 0])


def test_a_flight_begins_at_the_first_place_and_passes_all() -> None:
    """Times count from the first place, and every place is passed in order."""
    flight = simulate_draft(DRAFT, Limits(), 0.05)
    assert flight.time_s[0] == flight.passed_s[0] == 0.0
    assert (np.diff(flight.passed_s) > 0).all()
    assert flight.place_m[-1] == pytest.approx(DRAFT.places_m[-1], abs=2.5)


def test_speeds_before_every_leg_change_the_numbers_of_the_places() -> None:
    """Items count from 1; with a speed for every leg but the first, places are every second one."""
    assert items_of(DRAFT, Limits())[1] == [1, 2, 3, 4]
    assert items_of(DRAFT, Limits(), every_speed=True)[1] == [1, 3, 5, 7]


@pytest.mark.parametrize("every_speed", [False, True])
def test_items_of_a_changed_draft_are_made_of_those_before(every_speed: bool) -> None:
    """They are as if made anew, whichever column differs; those that do not differ are kept."""
    speeds, others = np.array([np.nan, 3.0, 5.0, 7.0]), np.array([np.nan, 3.0, 4.0, 7.0])
    before = replace(DRAFT, speed_m_s=speeds)
    items, seqs = items_of(before, Limits(), every_speed=every_speed)
    for change in (
        {"places_m": DRAFT.places_m + np.array([0.0, 1.0, 0.0])},
        {"spline": ~DRAFT.spline},
        {"hold_s": DRAFT.hold_s + np.array([0.0, 0.0, 2.0, 0.0])},
        {"speed_m_s": others},
    ):
        after = replace(before, **change)
        anew, _ = items_of(after, Limits(), every_speed=every_speed)
        assert items_changed(items, seqs, before, after, Limits()) == anew
    assert items_changed(items, seqs, before, replace(before), Limits()) == items


@pytest.mark.parametrize("takeoff_m", [2.0, 80.0])
def test_what_follows_a_climb_or_descent_begins_later(takeoff_m: float) -> None:
    """From take-off at another height the first leg lasts longer, as it does after all of that way."""
    level, after = (simulate_draft(DRAFT, Limits(), 0.02, Takeoff(0.0, up_m)) for up_m in (None, takeoff_m))
    mission = DRAFT.mission(FRAME, Limits())
    whole = simulate(mission, Limits(), start_m=(0.0, 0.0, takeoff_m), step_s=0.02)
    reached_s = [whole.reached_s[seq] for seq, _ in mission.waypoints[:2]]
    assert after.passed_s[1] == pytest.approx(reached_s[1] - reached_s[0], abs=0.1)
    assert after.passed_s[1] > level.passed_s[1] + 0.2


def test_only_the_end_of_the_way_from_take_off_is_flown() -> None:
    """Two metres of it; where the recording begins at another height than none is known of, nothing."""
    heights_m = [
        copter_after_takeoff(DRAFT, Limits(), 0.02, Takeoff(0.0, up_m)).position_m[2] - DRAFT.places_m[0, 2]
        for up_m in (None, 0.0, DRAFT.places_m[0, 2] + 0.5, 200.0)
    ]
    assert heights_m == [0.0, -2.0, 0.5, 2.0]


def test_a_flight_may_end_on_the_ground() -> None:
    """There it stays: what comes after is never reached. A real ArduCopter 4.6 came down on it, too."""
    flight = simulate_draft(DIVE, Limits(wp_accel_m_s2=1.0), 0.02)
    assert not flight.stays_up
    assert flight.place_m[-1, 2] == 0.0
    assert flight.passed_s[-1] == flight.time_s[-1] < 60.0


def test_a_flight_far_below_its_places_does_not_stay_up() -> None:
    """At 9 m/s it flies on, but goes down to 3 m instead of 10 m; at 3 m/s all is well."""
    lowest_m = {}
    for speed_m_s, stays_up in ((9.0, False), (3.0, True)):
        draft = replace(DIVE, speed_m_s=np.array([speed_m_s] + [np.nan] * 6))
        flight = simulate_draft(draft, Limits(wp_accel_m_s2=2.5), 0.02)
        assert flight.stays_up == stays_up
        lowest_m[speed_m_s] = float(flight.place_m[:, 2].min())
    assert 0 < lowest_m[9.0] < 5 < lowest_m[3.0]
