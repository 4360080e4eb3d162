"""velocity_pid.py: the horizontal velocity controller."""

from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.velocity_pid import VelocityPid


def answer_m_s2(limits: Limits) -> float:
    """The acceleration a step of 0.02 s after a velocity error of 1 m/s begins."""
    pid = VelocityPid(0.02, limits)
    pid.advance(limits, (0.0, 0.0))
    return pid.advance(limits, (1.0, 0.0))[0]


def test_both_filters_hold_the_answer_back() -> None:
    """That of the error all of it, that of its rate the derivative's part (AC_PID_2D::update_all)."""
    usual = answer_m_s2(Limits())
    assert answer_m_s2(Limits(velocity_error_hz=2.0)) < 0.6 * usual
    assert 0.4 * usual < answer_m_s2(Limits(velocity_d_hz=2.0)) < usual
