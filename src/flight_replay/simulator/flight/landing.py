"""Landing: the descent (Mode::land_run_vertical_control in mode.cpp) and its end (land_detector.cpp)."""

from __future__ import annotations

from flight_replay.simulator.dynamics.shaping import clamp, sqrt_controller
from flight_replay.simulator.flight.flight_control import FlightControl
from flight_replay.simulator.flight.submode import SubMode

# LAND_DETECTOR_TRIGGER_SEC.
_LAND_DETECTOR_S = 1.0
# LAND_WITH_DELAY_MS.
_PAUSE_S = 4.0
_MIN_ALT_LOW_M = 1.0


class Landing(SubMode):
    """Descend, slowly below LAND_ALT_LOW, until the land detector triggers; then spool down.

    It is done when the motors may stop.
    """

    def __init__(self, flight: FlightControl) -> None:
        self._flight = flight
        self.done = False
        self._still_s = 0.0
        self._pause_s = 0.0
        limits = flight.limits
        flight.control.set_speeds(limits.wp_speed_m_s, limits.wp_speed_up_m_s, limits.wp_speed_down_m_s)
        flight.control.limit_correction()
        flight.auto_yaw.hold()

    def pause(self) -> None:
        """Wait before the descent, as failsafes do (set_mode_land_with_pause)."""
        self._pause_s = _PAUSE_S

    def step(self) -> None:
        """Descend one step; on the ground, wait until the throttle is closed and all is still."""
        flight = self._flight
        limits, airframe, control = flight.limits, flight.airframe, flight.control
        control.update()
        control.input_stop_xy()
        low = max(limits.land_altitude_low_m, _MIN_ALT_LOW_M)
        slowest = abs(limits.land_speed_m_s)
        fastest = max(limits.land_speed_high_m_s or control.speed_down, slowest)
        rate = sqrt_controller(low - airframe.u, limits.position_z_p, control.accel_z_max, airframe.dt)
        self._pause_s -= airframe.dt
        control.input_climb_rate(0.0 if self._pause_s > 0 else clamp(rate, -fastest, -slowest))
        flight.auto_yaw.update()
        self._still_s = self._still_s + airframe.dt if airframe.on_ground and control.throttle <= 0 else 0.0
        self.done = self._still_s >= _LAND_DETECTOR_S + limits.spool_s
