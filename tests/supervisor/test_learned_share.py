"""What is learned in flight, of a vehicle that is late, one that only cuts corners, and one with drag."""

from __future__ import annotations

import numpy as np
import pytest

from flight_replay.supervisor.follower import Learned
from flight_replay.supervisor.learned_share import LearnedShare

STEP_S = 0.1


def circle(time_s: float, radius_m: float = 20.0, speed_m_s: float = 5.0) -> tuple[np.ndarray, np.ndarray]:
    """Where a circle is at a time, and how it moves there."""
    angle = speed_m_s / radius_m * time_s
    ahead, aside = (
        np.array([np.cos(angle), np.sin(angle), 0.0]),
        np.array([-np.sin(angle), np.cos(angle), 0.0]),
    )
    return radius_m * ahead, speed_m_s * aside


def flown(delay_s: float, seconds: float, radius_m: float = 20.0) -> LearnedShare:
    """What is learned from a vehicle that is where its target was ``delay_s`` before."""
    learned = Learned.nothing().lead_s
    for time_s in np.arange(0.0, seconds, STEP_S):
        position_m, velocity_m_s = circle(time_s - delay_s + learned.value, radius_m)
        learned.observe(time_s, circle(time_s)[0] - position_m, velocity_m_s)
    return learned


@pytest.mark.parametrize("delay_s", [-0.05, 0.0, 0.03, 0.1])
def test_a_delay_is_learned(delay_s: float) -> None:
    assert flown(delay_s, 120.0).value == pytest.approx(delay_s, abs=0.003)


def test_it_is_bounded() -> None:
    assert flown(3.0, 300.0).value == 0.4


def test_being_aside_teaches_nothing() -> None:
    """A circle flown too wide is not late."""
    learned = Learned.nothing().lead_s
    for time_s in np.arange(0.0, 60.0, STEP_S):
        position_m, velocity_m_s = circle(time_s)
        learned.observe(time_s, 0.05 * position_m, velocity_m_s)
    assert learned.value == pytest.approx(0.0, abs=1e-6)


def test_gaps_and_hovering_teach_nothing() -> None:
    learned = Learned.nothing().lead_s
    behind_m, north_m_s = np.array([1.0, 0.0, 0.0]), np.array([5.0, 0.0, 0.0])
    for time_s in (1.0, 31.0, 61.0):
        learned.observe(time_s, behind_m, north_m_s)
    for time_s in np.arange(61.1, 120.0, STEP_S):
        learned.observe(time_s, behind_m, 0.0 * north_m_s)
    assert learned.value == pytest.approx(0.0, abs=1e-9)


NORTH = np.array([1.0, 0.0, 0.0])


def straight(
    steps: int, step_s: float = STEP_S, behind_m: float = 1.0, speed_m_s: float = 5.0
) -> LearnedShare:
    """What is learned from a vehicle that flies north, always as far behind."""
    learned = Learned.nothing().lead_s
    for step in range(steps + 1):
        learned.observe(step * step_s, behind_m * NORTH, speed_m_s * NORTH)
    return learned


def test_a_fifteenth_of_the_delay_is_learned_in_a_second() -> None:
    """1 m behind at 5 m/s is 0.2 s late, or early where it is ahead."""
    assert straight(30).value == pytest.approx(0.2 * 3.0 / 15.0)
    assert straight(30, behind_m=-1.0).value == pytest.approx(-0.2 * 3.0 / 15.0)
    assert straight(300, behind_m=-9.0).value == -0.4


def test_below_one_metre_a_second_places_weigh_as_at_one() -> None:
    """0.1 m behind at 0.5 m/s teaches as 0.05 s late."""
    assert straight(30, behind_m=0.1, speed_m_s=0.5).value == pytest.approx(0.05 * 3.0 / 15.0)


def test_steps_up_to_half_a_second_teach() -> None:
    """A longer one is a gap, and the next step counts from its end."""
    assert straight(1, step_s=0.5).value == pytest.approx(0.2 * 0.5 / 15.0)
    learned = straight(1, step_s=0.51)
    assert learned.value == 0.0
    learned.observe(0.61, NORTH, 5.0 * NORTH)
    assert learned.value == pytest.approx(0.2 * 0.1 / 15.0)


def test_the_usual_speed_is_the_mean_of_thirty_seconds() -> None:
    """After 30 s at 10 m/s, two thirds of that square are usual: a slow place then weighs less."""
    learned = straight(300, behind_m=0.0, speed_m_s=10.0)
    learned.observe(30.1, NORTH, 2.0 * NORTH)
    usual_m2_s2 = 100.0 - 99.0 * np.exp(-1.0)
    assert learned.value == pytest.approx(2.0 / usual_m2_s2 * STEP_S / 15.0, rel=0.01)
