"""Stops of this program, flown by the flight model: how far off the path they lead the vehicle."""

from __future__ import annotations

import numpy as np
import pytest

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.geometry.reference_motion import ReferenceMotion
from flight_replay.planning.drag import sitl_drag
from flight_replay.planning.following.reference_planner import RecordedMotion, ReferenceBounds, plan_reference
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.flight.copter import Copter
from flight_replay.simulator.flight.guided import GuidedTarget
from flight_replay.supervisor.follower import LONGEST_GAP_S, TARGET_S, Follower
from flight_replay.vehicle.following import TARGET_TIMEOUT_S

LAPS_S = 16.0


@pytest.fixture(scope="module")
def reference() -> ReferenceMotion:
    """Figures of eight, flown with almost all the lean that the vehicle has."""
    time_s = np.arange(0.0, 2 * LAPS_S, 0.2)
    phase = 2 * np.pi * time_s / LAPS_S
    position_m = np.column_stack([18 * np.sin(phase), 9 * np.sin(2 * phase), np.full(len(phase), 30.0)])
    recorded = RecordedMotion(FlatFrame(47.0, 8.0), time_s, position_m, np.full(len(phase), np.nan))
    bounds = ReferenceBounds.of(Limits())
    return plan_reference(recorded, bounds, sitl_drag(0.0), headings=False, floor_m=5.0)


def _send(copter: Copter, follower: Follower, now_s: float) -> None:
    """Send the next target, as ``follow_phases`` does."""
    _, *motion = copter.motion
    position_m, velocity_m_s = np.array(motion[:3]), np.array(motion[3:6])
    if follower.gap_s(now_s) > LONGEST_GAP_S:
        follower.resume(now_s, position_m, velocity_m_s)
    else:
        follower.observe(now_s, position_m, velocity_m_s)
    target = follower.target(now_s)
    place, velocity, acceleration = target.position_m, target.velocity_m_s, target.acceleration_m_s2
    copter.follow(GuidedTarget(_vector(place), _vector(velocity), _vector(acceleration), 0.0, 0.0))


def _vector(values: Floats) -> Vector:
    return float(values[0]), float(values[1]), float(values[2])


def _farthest_off_m(reference: ReferenceMotion, stop_s: float, seconds: float) -> float:
    """How far off the path a vehicle comes whose targets stop at the reference's ``stop_s``."""
    follower = Follower(reference, max_error_m=3.0)
    limits = Limits(guided_timeout_s=TARGET_TIMEOUT_S)
    copter = Copter(limits, position_m=_vector(reference.state(reference.begin_s).position_m), yaw_rad=0.0)
    next_s, line_m, off_m = reference.begin_s, _line_m(reference), 0.0
    while (now_s := reference.begin_s + copter.time_s) < stop_s + seconds + 10.0:
        if now_s >= next_s - 1e-9 and not stop_s <= now_s < stop_s + seconds:
            _send(copter, follower, now_s)
            next_s = now_s + TARGET_S
        copter.step()
        if now_s > stop_s:
            apart_m = np.linalg.norm(line_m - np.array(copter.motion[1:3]), axis=1)
            off_m = max(off_m, float(apart_m.min()))
    return off_m


def _line_m(reference: ReferenceMotion) -> Floats:
    return reference.positions_m(np.arange(0.0, LAPS_S, 0.01))[:, :2]


@pytest.mark.parametrize(("seconds", "most_m"), [(0.7, 1.1), (1.0, 1.2), (3.0, 3.6)])
def test_a_stop_of_the_program_does_not_lead_the_vehicle_far_off(
    reference: ReferenceMotion, seconds: float, most_m: float
) -> None:
    """On average, in turns that leave next to no lean to spare."""
    stops_s = np.arange(2.0, 2.0 + LAPS_S / 2, 1.0)
    assert np.mean([_farthest_off_m(reference, float(stop_s), seconds) for stop_s in stops_s]) < most_m
