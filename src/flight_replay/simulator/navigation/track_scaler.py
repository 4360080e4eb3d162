"""How fast the target moves along its track: slower when the copter falls behind.

Source: AC_WPNav::advance_wp_target_along_track (track_scaler_dt).
"""

from __future__ import annotations

from math import cos, erf, exp, pi, sqrt
from typing import Final

from flight_replay.simulator.dynamics.airframe import Airframe
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.position_control import PositionControl
from flight_replay.simulator.dynamics.shaping import clamp
from flight_replay.simulator.dynamics.snapshot_part import SnapshotPart
from flight_replay.simulator.dynamics.vector import norm

# Speed that the target may have beyond the copter's.
_LEAD_SHARE: Final = 0.05
# Noise of the speed that a position estimate shows at rest. It decides whether the target starts
# fast or slow, by 0.2 s on a leg from rest; the model takes the mean.
_NOISE_M_S: Final = 0.005
_NO_NOISE: Final = 0.02
# A square below 1.2e-7 cm²/s² is none (is_positive in AP_Math.h).
_NO_SPEED_M_S: Final = 3.45e-6
_KEEPS_30_BITS: Final = 2.0**22
"""Added and taken away again it leaves 30 binary places: C libraries differ in the last bits of erf."""
_SQRT_HALF: Final = sqrt(0.5)
_DENSITY: Final = 1.0 / sqrt(2.0 * pi)
# After a stop the estimated speed is off to the left of the track, it seems because SITL's EKF3 takes
# the heading to be half a degree too large, and so the braking to be oblique. In over 100 stops at six
# places on earth the error rose and fell like a bell curve, up to 8 mm/s, plus or minus 4.
_DRIFT_M_S: Final = 0.008
_DRIFT_PEAK_S: Final = 1.9
_DRIFT_HALF_S: Final = 2.6
# A mission that begins in a climb, as many scripts let it, leaves the target with a speed so small that the
# estimate's noise decides between 0 and 1: seven flights had a scale of 0.75 to 0.86 after 1 s at rest.
# After climbs and descents of its own, eight stops of four missions, it was 1.
_AFTER_CLIMB_SCALE: Final = 0.5
_CLIMBING_M_S: Final = 0.15
# Speed above which the target's direction is one that it will have to brake from.
_MOVING_M_S: Final = 0.3
_RESTING_M_S: Final = 0.001


class _EstimateDrift(SnapshotPart):
    """The drift of the position estimate, ``rested_s`` after the target has come to rest."""

    __slots__ = ("_velocity", "rested_s")

    def __init__(self) -> None:
        self._velocity = (0.0, 0.0)
        self.rested_s = _DRIFT_PEAK_S + _DRIFT_HALF_S

    def set_velocity(self, vn: float, ve: float) -> None:
        """Note the velocity that the target will have to brake from."""
        self._velocity = vn, ve
        self.rested_s = 0.0

    def along(self, vn: float, ve: float) -> float:
        """Its scalar product with a velocity, m²/s²."""
        since_peak = (self.rested_s - _DRIFT_PEAK_S) / _DRIFT_HALF_S
        if self.rested_s == 0.0 or since_peak >= 1.0:
            return 0.0
        track_n, track_e = self._velocity
        speed = max(norm(track_n, track_e), _MOVING_M_S)
        return 0.5 * _DRIFT_M_S * (1.0 + cos(pi * since_peak)) * (track_e * vn - track_n * ve) / speed


class TrackScaler(SnapshotPart):
    """``scale`` is how much of each step's time the target moves on, 0 to 1 (_track_scalar_dt)."""

    __slots__ = ("_drift", "_rest_scale", "scale")

    def __init__(self, climb_m_s: float = 0.0) -> None:
        """Begin with a copter that climbs so fast."""
        self.scale = 1.0
        self._rest_scale = _AFTER_CLIMB_SCALE if climb_m_s > _CLIMBING_M_S else 1.0
        self._drift = _EstimateDrift()

    def advance(self, limits: Limits, control: PositionControl, airframe: Airframe) -> float:
        """Seconds that the target moves on in the next step.

        Target and airframe must be of the same time, and no farther apart than is corrected.
        """
        vn, ve, vu = control.vn, control.ve, control.vu
        speed = norm(vn, ve, vu)
        wanted = self._rest_scale
        drift = self._drift
        if speed > _MOVING_M_S:
            drift.set_velocity(vn, ve)
        elif speed < _RESTING_M_S or drift.rested_s > 0:
            drift.rested_s += airframe.dt
        if speed > _NO_SPEED_M_S:
            if norm(vn, ve) > abs(vu):
                self._rest_scale = 1.0
            behind = (
                (control.n - airframe.n) * vn + (control.e - airframe.e) * ve + (control.u - airframe.u) * vu
            )
            made_good = airframe.vn * vn + airframe.ve * ve + airframe.vu * vu + drift.along(vn, ve)
            wanted = _LEAD_SHARE + (made_good - limits.position_p * behind) / (speed * speed)
            wanted = mean_clamped(wanted, _NOISE_M_S / speed)
        smooth_s = limits.wp_accel_m_s2 / limits.wp_jerk_m_s3
        self.scale += (wanted - self.scale) * min(1.0, airframe.dt / smooth_s)
        return airframe.dt * self.scale


def mean_clamped(mean: float, deviation: float) -> float:
    """Mean of a normally distributed value that is limited to 0 and 1."""
    if deviation < _NO_NOISE:
        return clamp(mean, 0.0, 1.0)
    low, high = mean / deviation, (mean - 1.0) / deviation
    above_low, above_high = 0.5 * (1.0 + erf(low * _SQRT_HALF)), 0.5 * (1.0 + erf(high * _SQRT_HALF))
    density = exp(-0.5 * low * low) - exp(-0.5 * high * high)
    limited = mean * (above_low - above_high) + above_high + deviation * density * _DENSITY
    return clamp(limited + _KEEPS_30_BITS - _KEEPS_30_BITS, 0.0, 1.0)
