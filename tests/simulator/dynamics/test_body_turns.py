"""body_turns.py: turns of the body, and what they make of its lean, against rotations in space."""

import numpy as np
import pytest

from flight_replay.simulator.dynamics.body_turns import lean_rate, turn_between

LEANS = [(0.0, 0.0), (0.5, 0.0), (0.0, -0.5), (0.4, 0.3), (-0.5, 0.45), (0.6, -0.6)]


def axes(lean: tuple[float, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The body's x axis, which points ahead and up or down, its y axis, and its thrust: ahead, right, up."""
    thrust = np.array([*lean, 1.0]) / np.linalg.norm([*lean, 1.0])
    front = np.array([1.0, 0.0, -lean[0]]) / np.hypot(1.0, lean[0])
    return front, np.cross(thrust, front), thrust


def turned(lean: tuple[float, float], turn: tuple[float, float]) -> np.ndarray:
    """The lean after a turn about axes that stay where they are (Rodrigues)."""
    front, right, thrust = axes(lean)
    towards = front * turn[0] + right * turn[1]
    angle = float(np.hypot(*turn))
    after = thrust * np.cos(angle) + towards / max(angle, 1e-12) * np.sin(angle)
    return np.asarray(after[:2] / after[2])


@pytest.mark.parametrize("lean", LEANS)
@pytest.mark.parametrize("wanted", LEANS)
def test_a_turn_leads_to_the_lean_that_is_wanted(
    lean: tuple[float, float], wanted: tuple[float, float]
) -> None:
    """From 35 degrees one way to 35 the other, and to none at all."""
    assert turned(lean, turn_between(lean, wanted)) == pytest.approx(np.array(wanted), abs=0.005)


@pytest.mark.parametrize("lean", LEANS)
@pytest.mark.parametrize("rate", [(1.0, 0.0), (0.0, 1.0), (-2.0, 3.0)])
def test_a_lean_changes_as_the_body_turns(lean: tuple[float, float], rate: tuple[float, float]) -> None:
    """At 27 degrees of lean a turn changes it a quarter faster than from the level."""
    step_s = 1e-6
    after = turned(lean, (rate[0] * step_s, rate[1] * step_s))
    assert lean_rate(lean, rate) == pytest.approx((after - lean) / step_s, rel=1e-4, abs=1e-4)
