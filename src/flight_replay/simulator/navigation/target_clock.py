"""The clock of a target on its way: it slows down when the copter falls behind.

Source: AC_WPNav::advance_wp_target_along_track (track_scaler_dt).
"""

from __future__ import annotations

from math import cos, erf, exp, hypot, pi, sqrt

from flight_replay.simulator.dynamics.airframe import Airframe
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.position_control import PositionControl
from flight_replay.simulator.dynamics.shaping import clamp

# Speed that the target may have beyond the copter's.
_AHEAD_SHARE = 0.05
# Noise of the speed that a position estimate shows at rest. It decides whether the target's clock
# starts fast or slow, by 0.2 s on a leg from rest; the model takes the mean.
_NOISE_M_S = 0.005
_NOISE_MATTERS = 0.02
# A square below 1.2e-7 cm²/s² is none (is_positive in AP_Math.h).
_NO_SPEED_M_S = 3.45e-6
_SQRT_HALF, _BELL = sqrt(0.5), 1.0 / sqrt(2.0 * pi)
# After a stop the speed by the position estimate is off to the left of the way flown, it seems because
# SITL's EKF3 takes the heading to be half a degree too large, and so the braking to be oblique. In over
# 100 stops at six places of the earth it swelled and sank like a bell, to 8 mm/s, give or take 4.
_DRIFT_M_S, _DRIFT_PEAK_S, _DRIFT_HALF_S = 0.008, 1.9, 2.6
# Speed above which the target's way is one that it will have to brake from.
_UNDER_WAY_M_S = 0.3
_RESTING_M_S = 0.001


class _Drift:
    """The drift of the position estimate, ``rested_s`` after the target has come to rest."""

    __slots__ = ("_way", "rested_s")

    def __init__(self) -> None:
        self._way = (0.0, 0.0)
        self.rested_s = _DRIFT_PEAK_S + _DRIFT_HALF_S

    def under_way(self, vn: float, ve: float) -> None:
        """Note where the target is going to."""
        self._way = vn, ve
        self.rested_s = 0.0

    def along(self, vn: float, ve: float) -> float:
        """Its product with a velocity, m²/s²."""
        since_peak = (self.rested_s - _DRIFT_PEAK_S) / _DRIFT_HALF_S
        if self.rested_s == 0.0 or since_peak >= 1.0:
            return 0.0
        way_n, way_e = self._way
        level = max(hypot(way_n, way_e), _UNDER_WAY_M_S)
        return 0.5 * _DRIFT_M_S * (1.0 + cos(pi * since_peak)) * (way_e * vn - way_n * ve) / level


class TrackClock:
    """``rate`` is how fast the target's time runs, 0 to 1."""

    __slots__ = ("_drift", "rate")

    def __init__(self) -> None:
        self.rate = 1.0
        self._drift = _Drift()

    def advance(self, limits: Limits, control: PositionControl, body: Airframe) -> float:
        """Seconds of the target's time in the next step; target and airframe must be of the same time."""
        vn, ve, vu = control.vn, control.ve, control.vu
        speed = sqrt(vn * vn + ve * ve + vu * vu)
        wanted = 1.0
        drift = self._drift
        if speed > _UNDER_WAY_M_S:
            drift.under_way(vn, ve)
        elif speed < _RESTING_M_S or drift.rested_s > 0:
            drift.rested_s += body.dt
        if speed > _NO_SPEED_M_S:
            behind = (control.n - body.n) * vn + (control.e - body.e) * ve + (control.u - body.u) * vu
            made_good = body.vn * vn + body.ve * ve + body.vu * vu + drift.along(vn, ve)
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
