"""How fast the target moves along its track: slower when the copter falls behind.

Source: AC_WPNav::advance_wp_target_along_track (track_scaler_dt).
"""

from __future__ import annotations

from math import erf, exp, pi, sqrt
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
# fast or slow, by 0.2 s on a leg from rest; the model takes the mean. In SITL most of it comes from gyros
# that drift one way for five minutes and back for five (SIM_DRIFT_SPEED, SIM_DRIFT_TIME): the estimated
# heading is half a degree off to one side, and so is what a vehicle that brakes takes for its track.
_NOISE_M_S: Final = 0.005
_NO_NOISE: Final = 0.02
# A square below 1.2e-7 cm²/s² is none (is_positive in AP_Math.h).
_NO_SPEED_M_S: Final = 3.45e-6
_KEEPS_30_BITS: Final = 2.0**22
"""Added and taken away again it leaves 30 binary places: C libraries differ in the last bits of erf."""
_SQRT_HALF: Final = sqrt(0.5)
_DENSITY: Final = 1.0 / sqrt(2.0 * pi)
# A mission that begins in a climb, as many scripts let it, leaves the target with a speed so small that the
# estimate's noise decides between 0 and 1: seven flights had a scale of 0.75 to 0.86 after 1 s at rest.
# After climbs and descents of its own, eight stops of four missions, it was 1.
_AFTER_CLIMB_SCALE: Final = 0.5
_CLIMBING_M_S: Final = 0.15


class TrackScaler(SnapshotPart):
    """``scale`` is how much of each step's time the target moves on, 0 to 1 (_track_scalar_dt)."""

    __slots__ = ("_rest_scale", "scale")

    def __init__(self, climb_m_s: float = 0.0) -> None:
        """Begin with a copter that climbs so fast."""
        self.scale = 1.0
        self._rest_scale = _AFTER_CLIMB_SCALE if climb_m_s > _CLIMBING_M_S else 1.0

    def advance(self, limits: Limits, control: PositionControl, airframe: Airframe) -> float:
        """Seconds that the target moves on in the next step.

        Target and airframe must be of the same time, and no farther apart than is corrected.
        """
        vn, ve, vu = control.vn, control.ve, control.vu
        speed = norm(vn, ve, vu)
        wanted = self._rest_scale
        if speed > _NO_SPEED_M_S:
            if norm(vn, ve) > abs(vu):
                self._rest_scale = 1.0
            behind = (
                (control.n - airframe.n) * vn + (control.e - airframe.e) * ve + (control.u - airframe.u) * vu
            )
            made_good = airframe.vn * vn + airframe.ve * ve + airframe.vu * vu
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
