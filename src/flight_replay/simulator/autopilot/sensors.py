"""When GPS and EKF become usable, by the vehicle's clock since boot.

An ArduCopter SITL takes some 42 s of vehicle time until it can be armed. This copter goes through
the same stages in 9 s, so that a fast replay does not spend its time waiting.
"""

from __future__ import annotations

from dataclasses import dataclass

GYROS_CALIBRATED_S = 0.5
TILT_ALIGNED_S = 1.5
GPS_DETECTED_S = 2.0
GPS_FIX_S = 3.0
ORIGIN_S = 5.0
POSITION_S = 8.0

# EKF_STATUS_FLAGS as ArduCopter 4.6 reports them at each stage.
_UNINITIALISED, _ALIGNING, _CONSTANT_POSITION, _USING_GPS = 1024, 0, 167, 831

_TEXTS: tuple[tuple[float, str], ...] = (
    (0.1, "Calibrating barometer"),
    (0.4, "Barometer 1 calibration complete"),
    (0.4, "Barometer 2 calibration complete"),
    (GYROS_CALIBRATED_S, "ArduPilot Ready"),
    (GYROS_CALIBRATED_S, "AHRS: DCM active"),
    (1.0, "EKF3 IMU0 initialised"),
    (1.0, "EKF3 IMU1 initialised"),
    (1.0, "AHRS: EKF3 active"),
    (TILT_ALIGNED_S, "EKF3 IMU0 tilt alignment complete"),
    (TILT_ALIGNED_S, "EKF3 IMU1 tilt alignment complete"),
    (GPS_DETECTED_S, "GPS 1: detected u-blox"),
    (ORIGIN_S, "EKF3 IMU0 origin set"),
    (ORIGIN_S, "EKF3 IMU1 origin set"),
    (POSITION_S, "EKF3 IMU0 is using GPS"),
    (POSITION_S, "EKF3 IMU1 is using GPS"),
)


@dataclass(slots=True)
class Sensors:
    """The state of the sensors; ``gps_disabled`` takes the fix away, as SIM_GPS_DISABLE does."""

    time_s: float = 0.0
    gps_disabled: bool = False
    _lost_position_s: float | None = None

    def advance(self, time_s: float) -> list[str]:
        """Go on to ``time_s`` since boot; returns the status texts that come on the way."""
        texts = [text for at_s, text in _TEXTS if self.time_s < at_s <= time_s]
        self.time_s = time_s
        if not self.gps_disabled:
            self._lost_position_s = None
        elif self._lost_position_s is None:
            self._lost_position_s = time_s + 5.0
        return texts

    @property
    def fix_type(self) -> int:
        """GPS_FIX_TYPE: 0 no GPS, 1 no fix, 6 as ArduPilot's simulated GPS reports."""
        if self.time_s < GPS_DETECTED_S:
            return 0
        return 1 if self.time_s < GPS_FIX_S or self.gps_disabled else 6

    @property
    def attitude_ok(self) -> bool:
        """Whether attitude and height are known."""
        return self.time_s >= TILT_ALIGNED_S

    @property
    def origin_set(self) -> bool:
        """Whether the EKF has its origin, and with it home."""
        return self.time_s >= ORIGIN_S

    @property
    def position_ok(self) -> bool:
        """Whether the EKF gives a position; without GPS it does for 5 s more."""
        lost = self._lost_position_s is not None and self.time_s >= self._lost_position_s
        return self.time_s >= POSITION_S and not lost

    @property
    def ekf_flags(self) -> int:
        """EKF_STATUS_REPORT.flags."""
        if self.position_ok:
            return _USING_GPS
        if self.attitude_ok:
            return _CONSTANT_POSITION
        return _ALIGNING if self.time_s >= 1.0 else _UNINITIALISED
