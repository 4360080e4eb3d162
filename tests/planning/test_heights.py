"""Heights along a recording: the wanted ones, and those that can be kept in time."""

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.planning.fit import fit
from flight_replay.planning.heights import heights_of
from flight_replay.planning.prediction import with_prediction
from flight_replay.planning.route import route_of
from flight_replay.simulator.dynamics.limits import Limits
from tests.helpers.fit_tracks import wander
from tests.helpers.made_tracks import straight_track

JUMP_M = [10.0] * 25 + [40.0] * 26


def test_a_jump_is_wanted_and_a_ramp_is_planned() -> None:
    """Where the recorded times are kept; otherwise the vehicle takes the time that it needs."""
    track = straight_track(altitudes_m=JUMP_M)
    timed = heights_of(track, "recorded", timed_limits=Limits())
    assert timed.wanted_m.tolist() == JUMP_M
    assert np.abs(timed.planned_m - timed.wanted_m).max() > 10.0
    assert np.diff(timed.planned_m).max() < 2.6
    assert heights_of(track, "recorded").planned_m.tolist() == JUMP_M


def test_a_constant_altitude_is_planned_as_it_is() -> None:
    """Below the floor too: it was asked for."""
    heights = heights_of(straight_track(), 3.0, timed_limits=Limits())
    assert set(heights.wanted_m) == set(heights.planned_m) == {3.0}


def test_the_floor_is_an_option() -> None:
    """Recorded heights below it are raised to it, others are not."""
    track = straight_track(fixes=3, altitudes_m=[1.0, 8.0, 12.0])
    assert heights_of(track, "recorded", floor_m=2.0).wanted_m.tolist() == [2.0, 8.0, 12.0]
    assert heights_of(track, "recorded", floor_m=10.0).wanted_m.tolist() == [10.0, 10.0, 12.0]


def test_recorded_heights_can_be_raised() -> None:
    """The floor is that of what is flown; a constant altitude is what was asked for."""
    track = straight_track(fixes=3, altitudes_m=[-7.0, 8.0, 12.0])
    assert heights_of(track, "recorded", floor_m=5.0, raise_m=10.0).wanted_m.tolist() == [5.0, 18.0, 22.0]
    assert heights_of(track, 30.0, raise_m=10.0).wanted_m.tolist() == [30.0] * 3


@pytest.mark.slow
def test_a_fit_that_climbs_sooner_is_less_late() -> None:
    """A climb of 24 m in 4 s holds the vehicle up; at heights that it can have in time it keeps up."""
    track = wander(3)
    height_m = 10.0 + np.clip(6.0 * (track.time_s - track.time_s[0] - 13.0), 0.0, 24.0)
    climbing = replace(track, alt_m=height_m, amsl_m=400.0 + height_m)
    result = fit(climbing, max_points=30, altitude_m="recorded", speed_m_s="recorded")
    route = route_of("fit", result.mission, result.flown, heights=result.heights)
    predicted = with_prediction(route, 10.0).predicted
    assert predicted is not None
    assert predicted.position_m.statistics is not None
    assert predicted.position_m.statistics.mean < 2.5
    assert np.abs(result.heights.planned_m - result.heights.wanted_m).max() > 4.0
