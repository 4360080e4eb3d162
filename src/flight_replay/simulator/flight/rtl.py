"""RTL: climb, return, loiter above home, land (ArduCopter/mode_rtl.cpp)."""

from __future__ import annotations

from math import hypot

from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.flight.flight_control import FlightControl
from flight_replay.simulator.flight.landing import Landing
from flight_replay.simulator.flight.submode import SubMode

# RTL_ALT_MIN, RTL_MIN_CONE_SLOPE.
_MIN_RETURN_M = 0.3
_MIN_CONE_SLOPE = 0.5
# Altitudes are whole centimetres on board, so that some millimetres are always left to climb.
_ROUNDING_M = 0.002


class ReturnToLaunch(SubMode):
    """RTL from here; done when the motors may stop, which with RTL_ALT_FINAL above 0 is never."""

    def __init__(self, flight: FlightControl) -> None:
        self._flight = flight
        self._home = flight.home
        self.done = False
        navigation = flight.navigation
        navigation.start(flight.limits.rtl_speed_m_s)
        start = navigation.destination
        self._up_m = self._return_altitude(start)
        navigation.set_wp_destination((start[0], start[1], self._up_m))
        navigation.set_wp_destination_next((self._home[0], self._home[1], self._up_m))
        flight.auto_yaw.hold()
        self._substep = self._initial_climb
        self._loiter_s = flight.limits.rtl_loiter_s
        self._landing: Landing | None = None

    def _return_altitude(self, start: Vector) -> float:
        """Altitude to return at (ModeRTL::compute_return_target)."""
        limits, now = self._flight.limits, self._flight.airframe.u
        n, e, ground = self._home
        lowest = max(ground + _MIN_RETURN_M, now + max(0.0, limits.rtl_climb_min_m))
        up = max(ground + limits.rtl_altitude_m, lowest)
        if limits.rtl_cone_slope >= _MIN_CONE_SLOPE:
            cone = ground + hypot(start[0] - n, start[1] - e) * limits.rtl_cone_slope
            up = min(up, max(cone, lowest))
        return max(up, now, start[2] + _ROUNDING_M)

    @property
    def landing(self) -> bool:
        """Whether the landing has begun."""
        return self._landing is not None

    def step(self) -> None:
        """Fly one step of the present part."""
        self._substep()

    def _navigate(self) -> bool:
        self._flight.navigation.advance()
        self._flight.auto_yaw.update()
        return self._flight.navigation.reached

    def _initial_climb(self) -> None:
        if self._navigate():
            self._flight.navigation.set_wp_destination((self._home[0], self._home[1], self._up_m))
            self._flight.auto_yaw.set_default_mode(returning=True)
            self._substep = self._return_home

    def _return_home(self) -> None:
        if self._navigate():
            if not self._flight.auto_yaw.holds_in_rtl:
                self._flight.auto_yaw.reset_to_armed_yaw()
            self._substep = self._loiter_at_home

    def _loiter_at_home(self) -> None:
        """Wait above home, and until the heading is that of arming, if it is to be reset."""
        self._navigate()
        flight = self._flight
        self._loiter_s -= flight.airframe.dt
        if self._loiter_s > 0 or not (flight.auto_yaw.holds_in_rtl or flight.auto_yaw.reached):
            return
        flight.auto_yaw.hold()
        if flight.limits.rtl_altitude_final_m > 0:
            flight.control.init_z_at_stopping_point()
            self._substep = self._final_descent
        else:
            self._landing = Landing(flight)
            self._substep = self._land

    def _final_descent(self) -> None:
        """Descend to RTL_ALT_FINAL, and stay there (ModeRTL::descent_run)."""
        flight = self._flight
        flight.control.update()
        flight.control.input_stop_xy()
        flight.control.input_altitude(self._home[2] + flight.limits.rtl_altitude_final_m)
        flight.auto_yaw.update()

    def _land(self) -> None:
        if self._landing is not None:
            self._landing.step()
            self.done = self._landing.done
