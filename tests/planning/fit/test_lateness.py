"""What counts of a flight's position errors."""

import numpy as np
import pytest

from flight_replay.geometry.arrays import Floats
from flight_replay.planning.fit.lateness import (
    FAR_M,
    counted_offsets_m,
    lateness_cost_m,
    lateness_slope,
)
from flight_replay.planning.fit.reference import LocalTrack

LANES = np.array([(north, east) for east in (0.0, 20.0) for north in range(101)])
LANES[101:, 0] = LANES[:101, 0][::-1]
"""A metre a second north for 100 m, and back 20 m to the east of that."""


def counted_m(behind_s: float) -> tuple[Floats, Floats]:
    """What the position errors are, and what counts of them, of a vehicle so long behind the recorded one."""
    time_s = np.arange(202.0)
    recording = LocalTrack(time_s, LANES, np.zeros(202))
    off_m = recording.places_m[np.maximum(time_s - behind_s, 0).astype(int)] - recording.places_m
    return off_m, counted_offsets_m(off_m, recording, time_s + behind_s)


def test_a_vehicle_nearby_is_as_far_off_as_it_is() -> None:
    """Up to 6 m behind, to the last bit."""
    off_m, counts_m = counted_m(FAR_M)
    assert np.array_equal(off_m[:90], counts_m[:90])


def test_a_vehicle_on_the_lane_before_is_behind_by_all_of_the_way_between() -> None:
    """The recorded one is 50 m back on its way south, that one 49 m from the end of its own."""
    off_m, counts_m = counted_m(100.0)
    assert off_m[151].tolist() == [1.0, -20.0]
    assert counts_m[151] == pytest.approx([-119.0, 0.0], abs=0.1)
    assert np.linalg.norm(counts_m[110:190], axis=1) == pytest.approx(119.0, abs=1.0)


def test_nothing_counts_of_the_way_where_the_recorded_vehicle_stands() -> None:
    """A recording of one place has no way along, and no direction."""
    recording = LocalTrack(np.arange(3.0), np.zeros((3, 2)), np.zeros(3))
    off_m = np.array([[0.0, 0.0], [30.0, 0.0], [0.0, 0.0]])
    assert np.isfinite(counted_offsets_m(off_m, recording, np.arange(3.0))).all()


def test_far_off_a_metre_more_counts_less() -> None:
    """All of it up to 6 m, half of it at 12; what it counts has no steps."""
    late_m = np.linspace(0.0, 100.0, 10_001)
    slope = np.diff(lateness_cost_m(late_m)) / 0.01
    assert slope == pytest.approx(lateness_slope((late_m[1:] + late_m[:-1]) / 2), abs=1e-3)
    assert lateness_slope(np.array([0.0, FAR_M, 2 * FAR_M])).tolist() == [1.0, 1.0, 0.5]
