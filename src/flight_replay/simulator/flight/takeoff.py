"""Taking off, in GUIDED or by a mission's item (ArduCopter/takeoff.cpp, _AutoTakeoff::run)."""

from __future__ import annotations

from flight_replay.simulator.flight.phase import Flight

# Shares of the climb speed and acceleration that end the run-up and the take-off.
_RISING_SHARE = 0.5
_SETTLED_SHARE = 0.1
_FULL_THROTTLE = 0.9


class TakeOff:
    """Spool up, open the throttle until the copter rises, then climb to an altitude above home."""

    def __init__(self, flight: Flight, up_m: float) -> None:
        self._flight = flight
        self.up_m = up_m
        self.done = False
        self._wait_s = flight.arming_wait_s + flight.limits.spool_s if flight.body.on_ground else 0.0
        self._rising = not flight.body.on_ground
        self._throttle = 0.0
        flight.control.start_z()
        flight.heading.hold()

    def step(self) -> None:
        """Wait, run up, or climb."""
        if self._wait_s > 0:
            self._wait_s -= self._flight.body.dt
        elif not self._rising:
            self._run_up()
        else:
            self._climb()

    def _run_up(self) -> None:
        flight = self._flight
        limits, body, control = flight.limits, flight.body, flight.control
        self._throttle = min(1.0, self._throttle + body.dt / limits.takeoff_slew_s)
        body.step(0.0, 0.0, self._throttle)
        control.rest_here()
        self._rising = (
            self._throttle >= min(limits.takeoff_throttle_max, _FULL_THROTTLE)
            or body.accel_u >= _RISING_SHARE * control.accel_z_max
            or control.vu >= _SETTLED_SHARE * control.speed_up
        )

    def _climb(self) -> None:
        control = self._flight.control
        control.update()
        control.shape_rest()
        control.shape_altitude(self.up_m)
        self._flight.heading.update()
        slow = _SETTLED_SHARE * control.speed_up
        close = 0.5 * slow * slow / control.accel_z_max
        self.done = control.u >= self.up_m - close and control.vu < slow
