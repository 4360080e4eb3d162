"""Stops of this program, flown by the flight model: how far off the path they lead the vehicle."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from flight_replay.geometry.reference_motion import ReferenceMotion
from flight_replay.planning.drag import sitl_drag
from flight_replay.supervisor.follower import Follower
from tests.helpers.model_following import ModelFlight, figures_of_eight

LAP_S = 16.0


@pytest.fixture(scope="module")
def reference() -> ReferenceMotion:
    return figures_of_eight(sitl_drag(0.0), LAP_S, laps=2)


def _farthest_off_m(reference: ReferenceMotion, stop_s: float, seconds: float) -> float:
    """How far off the path a vehicle comes whose targets stop at the reference's ``stop_s``."""
    flight, places_m = ModelFlight(Follower(reference, max_error_m=3.0)), []
    while (now_s := flight.now_s) < stop_s + seconds + 8.0:
        flight.step(stopped=stop_s <= now_s < stop_s + seconds)
        if now_s > stop_s:
            places_m.append(flight.position_m)
    line = cKDTree(reference.positions_m(reference.times_s(0.01)))
    return float(line.query(np.array(places_m))[0].max())


@pytest.mark.parametrize(("seconds", "mean_m", "most_m"), [(0.7, 0.6, 1.0), (1.0, 0.8, 1.5), (3.0, 2.6, 5.0)])
def test_a_stop_of_the_program_does_not_lead_the_vehicle_far_off(
    reference: ReferenceMotion, seconds: float, mean_m: float, most_m: float
) -> None:
    """In turns that leave next to no lean to spare."""
    stops_s = np.arange(2.0, 2.0 + LAP_S / 2, 1.0)
    off_m = [_farthest_off_m(reference, float(stop_s), seconds) for stop_s in stops_s]
    assert np.mean(off_m) < mean_m
    assert max(off_m) < most_m
