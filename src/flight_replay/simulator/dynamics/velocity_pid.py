"""The horizontal velocity controller: a PID in the plane, as AC_PID_2D.cpp does it."""

from __future__ import annotations

from math import pi
from typing import Final

from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.snapshot_part import SnapshotPart
from flight_replay.simulator.dynamics.vector import norm

# PSC_VELXY_IMAX.
_INTEGRATOR_MAX: Final = 10.0


class VelocityPid(SnapshotPart):
    """Velocity error, m/s north and east, to acceleration, m/s²."""

    __slots__ = ("_begins", "_dt", "_error", "_error_part", "_integral", "_limited", "_rate", "_rate_part")

    def __init__(self, dt: float, limits: Limits) -> None:
        self.use_step(dt, limits)
        self.reset((0.0, 0.0))

    def use_step(self, dt: float, limits: Limits) -> None:
        """Use steps of such a duration, and the filters of some limits, from now on."""
        self._dt = dt
        self._error_part = _lowpass_part(dt, limits.velocity_error_hz)
        self._rate_part = _lowpass_part(dt, limits.velocity_d_hz)

    def reset(self, accel: tuple[float, float]) -> None:
        """Reset to an acceleration that is flown already."""
        self._integral = accel
        self._begins, self._error = True, (0.0, 0.0)
        self._rate = (0.0, 0.0)
        self._limited = (0.0, 0.0)

    @property
    def error(self) -> tuple[float, float]:
        """The filtered velocity error."""
        return self._error

    def set_limited(self, wanted: tuple[float, float]) -> None:
        """Set the acceleration that was not allowed, so that the integral does not grow that way."""
        self._limited = wanted

    def advance(self, limits: Limits, error: tuple[float, float]) -> tuple[float, float]:
        """Acceleration against a velocity error, one step on."""
        if self._begins:
            self._begins, self._error = False, error
        else:
            part, rate_part, dt = self._error_part, self._rate_part, self._dt
            before_n, before_e = self._error
            step_n, step_e = (error[0] - before_n) * part, (error[1] - before_e) * part
            self._error = before_n + step_n, before_e + step_e
            rate_n, rate_e = self._rate
            rate_n += (step_n / dt - rate_n) * rate_part
            rate_e += (step_e / dt - rate_e) * rate_part
            self._rate = rate_n, rate_e
        n, e = self._error
        integral_n, integral_e = self._next_integral(n * limits.velocity_i, e * limits.velocity_i)
        self._integral = integral_n, integral_e
        p, d = limits.velocity_p, limits.velocity_d
        return n * p + integral_n + self._rate[0] * d, e * p + integral_e + self._rate[1] * d

    def _next_integral(self, growth_n: float, growth_e: float) -> tuple[float, float]:
        """The integral a step on; it does not grow against a limit (AC_PID_2D::update_i)."""
        n, e = self._integral
        most = _INTEGRATOR_MAX
        if growth_n * self._limited[0] + growth_e * self._limited[1] > 0:
            most = norm(n, e)
        n, e = n + growth_n * self._dt, e + growth_e * self._dt
        size = norm(n, e)
        return (n * most / size, e * most / size) if size > most else (n, e)


def _lowpass_part(dt: float, cutoff_hz: float) -> float:
    """What part of a change passes a low-pass filter in a step (calc_lowpass_alpha_dt)."""
    return dt / (dt + 1.0 / (2.0 * pi * cutoff_hz))
