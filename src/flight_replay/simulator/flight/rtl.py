"""RTL: climb, fly home, wait above it, land (ArduCopter/mode_rtl.cpp)."""

from __future__ import annotations

from math import hypot

from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.flight.landing import Landing
from flight_replay.simulator.flight.phase import Flight

# RTL_ALT_MIN, RTL_MIN_CONE_SLOPE.
_LOWEST_RETURN_M = 0.3
_SHALLOWEST_CONE = 0.5
# Altitudes are whole centimetres on board, so that some millimetres are always left to climb.
_ROUNDING_M = 0.002


class Return:
    """RTL from here; it is done when the motors may stop, and never if RTL_ALT_FINAL is above ground."""

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self.done = False
        navigation = flight.navigation
        navigation.start(flight.limits.rtl_speed_m_s)
        start = navigation.destination
        self._up_m = self._return_altitude(start)
        navigation.fly_straight((start[0], start[1], self._up_m))
        navigation.then_straight((0.0, 0.0, self._up_m))
        flight.heading.hold()
        self._run = self._climb
        self._wait_s = flight.limits.rtl_loiter_s
        self._landing: Landing | None = None

    def _return_altitude(self, start: Vector) -> float:
        """Altitude to return at (ModeRTL::compute_return_target)."""
        limits, now = self._flight.limits, self._flight.body.u
        lowest = max(_LOWEST_RETURN_M, now + max(0.0, limits.rtl_climb_min_m))
        up = max(limits.rtl_altitude_m, lowest)
        if limits.rtl_cone_slope >= _SHALLOWEST_CONE:
            up = min(up, max(hypot(start[0], start[1]) * limits.rtl_cone_slope, lowest))
        return max(up, now, start[2] + _ROUNDING_M)

    @property
    def landing(self) -> bool:
        """Whether the last part has begun."""
        return self._landing is not None

    def step(self) -> None:
        """Fly one step of whichever part is on."""
        self._run()

    def _navigate(self) -> bool:
        self._flight.navigation.advance()
        self._flight.heading.update()
        return self._flight.navigation.reached

    def _climb(self) -> None:
        if self._navigate():
            self._flight.navigation.fly_straight((0.0, 0.0, self._up_m))
            self._flight.heading.use_default(returning=True)
            self._run = self._go_home

    def _go_home(self) -> None:
        if self._navigate():
            if not self._flight.heading.holds_when_returning:
                self._flight.heading.face_as_armed()
            self._run = self._wait

    def _wait(self) -> None:
        """Wait above home, and until the heading is that of arming, if it had changed."""
        self._navigate()
        flight = self._flight
        self._wait_s -= flight.body.dt
        if self._wait_s > 0 or not (flight.heading.holds_when_returning or flight.heading.reached):
            return
        flight.heading.hold()
        if flight.limits.rtl_altitude_final_m > 0:
            flight.control.start_z_at_stopping_point()
            self._run = self._descend
        else:
            self._landing = Landing(flight)
            self._run = self._land

    def _descend(self) -> None:
        """Descend to RTL_ALT_FINAL, and stay there (ModeRTL::descent_run)."""
        flight = self._flight
        flight.control.update()
        flight.control.shape_rest()
        flight.control.shape_altitude(flight.limits.rtl_altitude_final_m)
        flight.heading.update()

    def _land(self) -> None:
        if self._landing is not None:
            self._landing.step()
            self.done = self._landing.done
