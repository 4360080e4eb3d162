"""What whole passes teach, with a vehicle that misses in the same way each time, and one at a limit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.reference_motion import ReferenceMotion, SmoothMotion
from flight_replay.planning.following.followed_route import FollowOptions, followed_route
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.flight.copter import STEP_S, Copter
from flight_replay.simulator.flight.guided import GuidedTarget
from flight_replay.supervisor.follower import Follower, Learned
from flight_replay.supervisor.learned_passes import LearnedPasses, mean_miss_m
from tests.helpers.fit_tracks import eights
from tests.helpers.supervised import s_curve

TIMES_S = s_curve().times_s(0.1)
Misses = list[tuple[float, Floats]]


def missing(miss_m: Floats, displacement: SmoothMotion | None = None) -> Misses:
    """The misses (n, 3) of a vehicle that flies where its targets are, less ``miss_m``."""
    moved = 0.0 if displacement is None else displacement.positions_m(TIMES_S)
    return [(float(time_s), miss) for time_s, miss in zip(TIMES_S, miss_m - moved, strict=True)]


def aside(amount_m: float, period_s: float = 10.0) -> Floats:
    """To be missed north, in waves."""
    return np.column_stack([amount_m * np.sin(2 * np.pi * TIMES_S / period_s), *np.zeros((2, len(TIMES_S)))])


def test_what_is_always_missed_is_taken_out() -> None:
    learned, always_m = LearnedPasses(s_curve()), aside(0.4)
    displacement = learned.learn(missing(always_m))
    displacement = learned.learn(missing(always_m, displacement))
    left_m = missing(always_m, displacement)
    inside = [(time_s, miss) for time_s, miss in left_m if 0.0 < time_s < 40.0]
    assert mean_miss_m(inside) < 0.01


def test_noise_is_not_learned() -> None:
    noise_m = 0.2 * np.random.default_rng(1).standard_normal((len(TIMES_S), 3))
    displacement = LearnedPasses(s_curve()).learn(missing(noise_m))
    assert np.abs(displacement.positions_m(TIMES_S)).max() < 0.25
    assert np.abs(displacement.positions_m(TIMES_S)).mean() < 0.06


def test_a_vehicle_at_a_limit_teaches_nothing_there() -> None:
    """Where it was far off, and a second around that, targets stay on the reference."""
    far_m = aside(0.3)
    stuck = (TIMES_S > 15.0) & (TIMES_S < 20.0)
    far_m[stuck] = [3.0, 0.0, 0.0]
    displacement = LearnedPasses(s_curve()).learn(missing(far_m)).positions_m(TIMES_S)
    assert np.abs(displacement[stuck]).max() < 0.02
    assert np.abs(displacement).max() > 0.25


def test_targets_are_never_moved_by_more_than_a_metre() -> None:
    learned, always_m = LearnedPasses(s_curve()), np.tile([0.6, 0.0, 0.0], (len(TIMES_S), 1))
    for _ in range(4):
        displacement = learned.learn(missing(always_m)).positions_m(TIMES_S)
    assert np.linalg.norm(displacement, axis=1).max() <= 1.001


def test_it_begins_and_ends_on_the_reference() -> None:
    always_m = np.tile([0.5, 0.0, 0.0], (len(TIMES_S), 1))
    displacement = LearnedPasses(s_curve()).learn(missing(always_m)).positions_m(TIMES_S)
    assert np.abs(displacement[[0, -1]]).max() < 0.1
    assert displacement[len(displacement) // 2, 0] == pytest.approx(0.5, abs=0.01)


def test_a_worse_pass_is_taken_back_and_the_next_step_halved() -> None:
    learned, always_m = LearnedPasses(s_curve()), aside(0.4)
    first = learned.learn(missing(always_m)).positions_m(TIMES_S)
    second = learned.learn(missing(2.0 * always_m / 1.5)).positions_m(TIMES_S)
    assert second == pytest.approx(first / 2)


def test_a_pass_without_a_position_teaches_nothing() -> None:
    displacement = LearnedPasses(s_curve()).learn([])
    assert np.abs(displacement.positions_m(TIMES_S)).max() == 0.0
    assert mean_miss_m([]) == np.inf


def model_pass(reference: ReferenceMotion, learned: Learned) -> Follower:
    """A pass of the flight model on a link without delay."""
    follower, state = Follower(reference, 3.0, learned=learned), reference.state(reference.begin_s)
    copter = Copter(Limits(), position_m=(*state.position_m.tolist(),))
    for step in range(round((reference.end_s - reference.begin_s) / STEP_S)):
        if step % 5 == 0:
            follower.observe(copter.time_s, np.array(copter.position_m), np.array(copter.velocity_m_s))
            target = follower.target(copter.time_s)
            place, speed, push = (
                (float(north), float(east), float(up))
                for north, east, up in (target.position_m, target.velocity_m_s, target.acceleration_m_s2)
            )
            copter.follow(GuidedTarget(place, speed, push), 0.0)
        copter.step()
    return follower


def test_arducopter_is_nearer_with_each_pass() -> None:
    """As the flight model flies it: a quarter of the misses is left after two passes."""
    track = eights(laps=2)
    reference = followed_route(track, track.alt_m, Limits(), FollowOptions()).reference
    assert reference is not None
    passes, learned, off_m = LearnedPasses(reference), Learned.nothing(), []
    for _ in range(3):
        misses = model_pass(reference, learned).misses
        off_m.append(mean_miss_m(misses))
        learned = replace(learned, displacement=passes.learn(misses))
    assert off_m[1] < 0.5 * off_m[0]
    assert off_m[2] < 0.25 * off_m[0]
