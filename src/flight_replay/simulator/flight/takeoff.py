"""Taking off, in GUIDED or by a mission's item (ArduCopter/takeoff.cpp, _AutoTakeoff::run)."""

from __future__ import annotations

from flight_replay.simulator.flight.flight_control import FlightControl
from flight_replay.simulator.flight.submode import SubMode

# Shares of climb speed and acceleration at which the copter counts as lifted off, and the take-off as done.
_LIFTED_OFF_SHARE = 0.5
_SETTLED_SHARE = 0.1
_FULL_THROTTLE = 0.9


class TakeOff(SubMode):
    """Spool up, raise the throttle until the copter lifts off, then climb to an altitude above home."""

    def __init__(self, flight: FlightControl, up_m: float) -> None:
        self._flight = flight
        self.up_m = up_m
        self.done = False
        self._wait_s = flight.arming_wait_s + flight.limits.spool_s if flight.airframe.on_ground else 0.0
        self._lifted_off = not flight.airframe.on_ground
        self._throttle = 0.0
        flight.control.init_z()
        flight.auto_yaw.hold()

    def step(self) -> None:
        """Spool up, raise the throttle, or climb."""
        if self._wait_s > 0:
            self._wait_s -= self._flight.airframe.dt
        elif not self._lifted_off:
            self._raise_throttle()
        else:
            self._climb()

    def _raise_throttle(self) -> None:
        flight = self._flight
        limits, airframe, control = flight.limits, flight.airframe, flight.control
        self._throttle = min(1.0, self._throttle + airframe.dt / limits.takeoff_slew_s)
        airframe.step(0.0, 0.0, self._throttle)
        control.init_xyz()
        self._lifted_off = (
            self._throttle >= min(limits.takeoff_throttle_max, _FULL_THROTTLE)
            or airframe.accel_u >= _LIFTED_OFF_SHARE * control.accel_z_max
            or control.vu >= _SETTLED_SHARE * control.speed_up
        )

    def _climb(self) -> None:
        control = self._flight.control
        control.update()
        control.input_stop_xy()
        control.input_altitude(self.up_m)
        self._flight.auto_yaw.update()
        slow = _SETTLED_SHARE * control.speed_up
        close = 0.5 * slow * slow / control.accel_z_max
        self.done = control.u >= self.up_m - close and control.vu < slow
