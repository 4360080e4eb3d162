"""Landing: the descent (Mode::land_run_vertical_control in mode.cpp) and its end (land_detector.cpp)."""

from __future__ import annotations

from flight_replay.simulator.dynamics.shaping import clamp, sqrt_controller
from flight_replay.simulator.flight.phase import Flight

# LAND_DETECTOR_TRIGGER_SEC.
_LANDED_AFTER_S = 1.0
_LOWEST_SLOW_M = 1.0


class Landing:
    """Descend, slowly from LAND_ALT_LOW on, until the land detector is sure; then spool down.

    When it is done, the motors stop.
    """

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self.done = False
        self._still_s = 0.0
        limits = flight.limits
        flight.control.set_speeds(limits.wp_speed_m_s, limits.wp_speed_up_m_s, limits.wp_speed_down_m_s)
        flight.heading.hold()

    def step(self) -> None:
        """Descend one step; on the ground, wait until the throttle is closed and all is still."""
        flight = self._flight
        limits, body, control = flight.limits, flight.body, flight.control
        control.update()
        control.shape_rest()
        low = max(limits.land_altitude_low_m, _LOWEST_SLOW_M)
        slowest = abs(limits.land_speed_m_s)
        fastest = max(limits.land_speed_high_m_s or control.speed_down, slowest)
        rate = sqrt_controller(low - body.u, limits.position_z_p, control.accel_z_max, body.dt)
        control.shape_climb(clamp(rate, -fastest, -slowest))
        flight.heading.update()
        self._still_s = self._still_s + body.dt if body.on_ground and control.throttle <= 0 else 0.0
        self.done = self._still_s >= _LANDED_AFTER_S + limits.spool_s
