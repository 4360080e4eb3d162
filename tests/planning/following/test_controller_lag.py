"""What controllers leave: its size in a steady flight, and what targets displaced by it are worth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.reference_motion import ReferenceMotion, SmoothMotion
from flight_replay.planning.drag import Drag
from flight_replay.planning.following.controller_lag import acceleration_lag, drag_lag
from flight_replay.planning.following.follow_prediction import with_prediction
from flight_replay.planning.following.followed_route import FollowOptions, followed_route, reference_for
from flight_replay.planning.route import Route
from flight_replay.planning.vehicle_limits import VehicleLimits
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.supervisor.follower import DEFAULT_TUNING, Tuning
from tests.helpers.fake_vehicle import FRAME
from tests.helpers.fit_tracks import eights

TIMES_S = np.arange(0.0, 60.0, 0.5)
DRAG = Drag(0.3, 0.02)
OLD, OLD_LIMITS = (
    Tuning(feed_forward=0.4, delay_s=0.25),
    Limits(velocity_p=1.0, velocity_i=0.5, velocity_d=0.0),
)


def moving(speeds_m_s: Floats) -> ReferenceMotion:
    """A reference that moves north at speeds (n,)."""
    north_m = np.concatenate([[0.0], np.cumsum((speeds_m_s[1:] + speeds_m_s[:-1]) / 4)])
    places_m = np.column_stack([north_m, *np.zeros((2, len(TIMES_S)))])
    spline = make_interp_spline(TIMES_S, places_m, k=3)
    return ReferenceMotion(frame=FRAME, begin_s=0.0, end_s=float(TIMES_S[-1]), position=spline)


STARTING = moving(5.0 * np.clip(TIMES_S / 4.0, 0.0, 1.0))


def known_lag(reference: ReferenceMotion, drag: Drag, limits: Limits) -> SmoothMotion:
    lag = drag_lag(reference, drag, limits)
    assert lag is not None
    return lag


def lag_m(reference: ReferenceMotion, drag: Drag, time_s: float) -> float:
    return float(known_lag(reference, drag, Limits()).state(time_s).position_m[0])


def test_the_integral_makes_up_for_steady_drag() -> None:
    assert lag_m(STARTING, DRAG, 4.0) > 0.3
    assert lag_m(STARTING, DRAG, 30.0) == pytest.approx(0.0, abs=0.01)


def test_twice_the_drag_is_twice_the_lag() -> None:
    assert lag_m(STARTING, Drag(0.6, 0.04), 4.0) == pytest.approx(2 * lag_m(STARTING, DRAG, 4.0))
    assert lag_m(STARTING, Drag(0.0, 0.0), 4.0) == 0.0


@pytest.mark.parametrize("limits", [Limits(), Limits(velocity_p=1.0, velocity_i=0.5, velocity_d=0.0)])
def test_it_is_what_the_controllers_need(limits: Limits) -> None:
    """What they make of it is the drag: by feed-forward, in proportion, by integral and derivative."""
    times_s = np.arange(0.0, 59.0, 0.01)
    lag = known_lag(STARTING, DRAG, limits)
    place, velocity = lag.positions_m(times_s)[:, 0], lag.velocities_m_s(times_s)[:, 0]
    acceleration = lag.accelerations_m_s2(times_s)[:, 0]
    error = velocity + limits.position_p * place
    made = acceleration + limits.velocity_p * error + limits.velocity_i * np.cumsum(error) * 0.01
    made += limits.velocity_d * (acceleration + limits.position_p * velocity)
    drag = DRAG.acceleration_m_s2(STARTING.velocities_m_s(times_s)[:, :2])[:, 0]
    assert np.abs(made - drag).mean() < 0.05


def test_what_old_firmware_does_not_feed_forward_is_made_up_for() -> None:
    """Of 3.3: a share of how the wanted velocity changes, and its errors, have to make the acceleration."""
    reference = moving(4.0 * np.sin(TIMES_S / 2.0) * np.clip(TIMES_S / 8.0, 0.0, 1.0))
    lag = acceleration_lag(reference, OLD_LIMITS, OLD)
    assert lag is not None
    times_s = np.arange(0.0, 59.0, 0.01)
    place, velocity = lag.positions_m(times_s)[:, 0], lag.velocities_m_s(times_s)[:, 0]
    error = velocity + place
    made = 0.4 * np.gradient(reference.velocities_m_s(times_s)[:, 0] + error, 0.01)
    made += error + 0.5 * np.cumsum(error) * 0.01
    wanted = reference.accelerations_m_s2(np.clip(times_s + 0.25, 0.0, 59.5))[:, 0]
    assert np.abs(made - wanted).mean() < 0.05 * np.abs(wanted).mean() + 0.02


def test_what_is_fed_forward_in_time_leaves_no_lag() -> None:
    assert acceleration_lag(STARTING, Limits(), DEFAULT_TUNING) is None
    track = eights(laps=1)
    route = followed_route(track, track.alt_m, Limits(), FollowOptions())
    assert route.reference is not None
    assert reference_for(route.reference, route, DEFAULT_TUNING) is route.reference
    old_limits = replace(route, limits=VehicleLimits(OLD_LIMITS))
    old = reference_for(route.reference, old_limits, OLD)
    assert old.acceleration_lag is not None
    assert old.drag_lag is not route.reference.drag_lag


def test_gains_that_are_none_move_no_target_far() -> None:
    """A vehicle's parameters may be anything: the displacement is bounded, or there is none."""
    loose = known_lag(STARTING, DRAG, Limits(position_p=0.01, velocity_p=0.01, velocity_i=0.0))
    assert 2.0 < np.linalg.norm(loose.positions_m(TIMES_S[:-1]), axis=1).max() < 5.2
    assert drag_lag(STARTING, DRAG, Limits(velocity_p=float("nan"))) is None
    assert drag_lag(STARTING, DRAG, Limits(velocity_p=-1e6)) is None


def _predicted_m(route: Route) -> float:
    predicted = with_prediction(route, 3.0).predicted
    assert predicted is not None
    assert predicted.position_m.statistics is not None
    return predicted.position_m.statistics.mean


def test_targets_displaced_by_it_are_followed_more_closely() -> None:
    """In turns and where the speed changes."""
    track = eights(laps=3)
    route = followed_route(track, track.alt_m, Limits(), FollowOptions())
    assert route.reference is not None
    assert route.reference.drag_lag is not None
    without = replace(route, reference=replace(route.reference, drag_lag=None))
    assert _predicted_m(route) < 0.9 * _predicted_m(without)
