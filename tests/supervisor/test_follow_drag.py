"""Vehicles with more drag than was planned with, flown by the flight model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.geometry.reference_motion import ReferenceMotion
from flight_replay.planning.drag import sitl_drag
from flight_replay.planning.following.controller_lag import drag_lag
from flight_replay.planning.following.followed_route import thrust_of
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.supervisor.follower import TARGET_S, Follower
from tests.helpers.model_following import ModelFlight, figures_of_eight

LAPS, LAP_S = 5, 18.0
TWICE_THE_DRAG_AMSL_M = -10_000.0  # At 8 m/s, in air that is so dense.


@pytest.fixture(scope="module")
def reference() -> ReferenceMotion:
    drag, limits = sitl_drag(0.0), Limits()
    motion = figures_of_eight(drag, LAP_S, LAPS)
    return replace(motion, drag_lag=drag_lag(motion, drag, limits), thrust=thrust_of(drag, limits))


def _flown(reference: ReferenceMotion, home_amsl_m: float) -> tuple[float, float]:
    """How far from where it was to be, on average, once drag was learned, and how long the clock waited."""
    follower = Follower(reference, max_error_m=3.0)
    flight, off_m = ModelFlight(follower, home_amsl_m), []
    while follower.recording_s < LAPS * LAP_S:
        flight.step()
        if follower.recording_s > 2 * LAP_S and follower.gap_s(flight.now_s) < TARGET_S / 4:
            off_m.append(np.linalg.norm(flight.position_m - reference.state(follower.recording_s).position_m))
    return float(np.mean(off_m)), flight.now_s - follower.recording_s


def test_a_vehicle_with_twice_the_drag_is_waited_for_before_its_lean_is_used_up(
    reference: ReferenceMotion,
) -> None:
    off_m, waited_s = _flown(reference, TWICE_THE_DRAG_AMSL_M)
    before_m, _ = _flown(replace(reference, thrust=None), TWICE_THE_DRAG_AMSL_M)
    assert off_m < 0.5 * before_m
    assert waited_s < LAP_S


def test_a_vehicle_with_the_drag_that_was_planned_with_is_not_waited_for(reference: ReferenceMotion) -> None:
    assert _flown(reference, 0.0)[1] == pytest.approx(0.0, abs=TARGET_S)
