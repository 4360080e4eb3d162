"""The clock of a target on its way: it slows down when the copter falls behind.

Source: AC_WPNav::advance_wp_target_along_track (track_scaler_dt).
"""

from __future__ import annotations

from math import erf, exp, pi, sqrt

from flight_replay.simulator.airframe import Airframe
from flight_replay.simulator.control import clamp
from flight_replay.simulator.limits import Limits
from flight_replay.simulator.position_control import PositionControl

# Speed that the target may have beyond the copter's.
_AHEAD_SHARE = 0.05
# Noise of the speed that a position estimate shows at rest. It decides whether the target's clock
# starts fast or slow, by 0.2 s on a leg from rest; the model takes the mean.
_NOISE_M_S = 0.005
_NOISE_MATTERS = 0.02
# A square below 1.2e-7 cm²/s² is none (is_positive in AP_Math.h).
_NO_SPEED_M_S = 3.45e-6
_SQRT_HALF, _BELL = sqrt(0.5), 1.0 / sqrt(2.0 * pi)


class TrackClock:
    """``rate`` is how fast the target's time runs, 0 to 1."""

    __slots__ = ("rate",)

    def __init__(self) -> None:
        self.rate = 1.0

    def advance(self, limits: Limits, control: PositionControl, body: Airframe) -> float:
        """Seconds of the target's time in the next step; target and airframe must be of the same time."""
        vn, ve, vu = control.vn, control.ve, control.vu
        speed = sqrt(vn * vn + ve * ve + vu * vu)
        wanted = 1.0
        if speed > _NO_SPEED_M_S:
            behind = (control.n - body.n) * vn + (control.e - body.e) * ve + (control.u - body.u) * vu
            made_good = body.vn * vn + body.ve * ve + body.vu * vu
            wanted = _AHEAD_SHARE + (made_good - limits.position_p * behind) / (speed * speed)
            wanted = mean_clamped(wanted, _NOISE_M_S / speed)
        smooth_s = limits.wp_accel_m_s2 / limits.wp_jerk_m_s3
        self.rate += (wanted - self.rate) * min(1.0, body.dt / smooth_s)
        return body.dt * self.rate


def mean_clamped(mean: float, deviation: float) -> float:
    """Mean of a normally distributed value that is kept within 0 and 1."""
    if deviation < _NOISE_MATTERS:
        return clamp(mean, 0.0, 1.0)
    low, high = mean / deviation, (mean - 1.0) / deviation
    above_low, above_high = 0.5 * (1.0 + erf(low * _SQRT_HALF)), 0.5 * (1.0 + erf(high * _SQRT_HALF))
    bell = exp(-0.5 * low * low) - exp(-0.5 * high * high)
    return clamp(mean * (above_low - above_high) + above_high + deviation * bell * _BELL, 0.0, 1.0)
