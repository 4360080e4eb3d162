"""What a copter can be doing: standing, taking off, holding, going somewhere, landing, returning.

A phase's ``step`` flies the airframe one step. Sources: ArduCopter's takeoff.cpp
(_AutoTakeoff::run), mode_guided.cpp, mode.cpp (land_run_vertical_control), land_detector.cpp,
mode_rtl.cpp. Metres north, east, up of home.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot
from typing import Protocol

from flight_replay.simulator.airframe import Airframe
from flight_replay.simulator.control import clamp, sqrt_controller
from flight_replay.simulator.heading import Heading
from flight_replay.simulator.limits import Limits
from flight_replay.simulator.position_control import PositionControl
from flight_replay.simulator.scurve import Vector
from flight_replay.simulator.wpnav import WaypointNavigation

# takeoff.cpp: shares of the climb speed and acceleration that end the run-up and the take-off.
_RISING_SHARE = 0.5
_SETTLED_SHARE = 0.1
# mode_rtl.cpp: RTL_ALT_MIN, RTL_MIN_CONE_SLOPE.
_LOWEST_RETURN_M = 0.3
_SHALLOWEST_CONE = 0.5
_ROUNDING_M = 0.002
# land_detector.cpp: LAND_DETECTOR_TRIGGER_SEC.
_LANDED_AFTER_S = 1.0


@dataclass(slots=True)
class Flight:
    """What phases share: the airframe, its controllers and the parameters."""

    limits: Limits
    body: Airframe
    control: PositionControl
    navigation: WaypointNavigation
    heading: Heading

    @property
    def position(self) -> Vector:
        """Where the airframe is."""
        return self.body.n, self.body.e, self.body.u

    def use_limits(self, limits: Limits) -> None:
        """Go by other parameters from now on."""
        self.limits = limits
        for part in (self.body, self.control, self.navigation, self.heading):
            part.use_limits(limits)


class Phase(Protocol):
    """Something that a copter does."""

    done: bool

    def step(self) -> None:
        """Fly one step."""


class Standing:
    """On the ground; nothing moves."""

    done = False

    def step(self) -> None:
        """Stand."""


class TakeOff:
    """Spool up, open the throttle until the copter rises, then climb to an altitude above home."""

    def __init__(self, flight: Flight, up_m: float, *, wait_s: float = 0.0) -> None:
        self._flight = flight
        self.up_m = up_m
        self.done = False
        self._wait_s = wait_s + (flight.limits.spool_s if flight.body.on_ground else 0.0)
        self._rising = not flight.body.on_ground
        self._throttle = 0.0
        flight.control.start_z()
        flight.heading.hold()

    def step(self) -> None:
        """Run up, or climb."""
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
            self._throttle >= min(limits.takeoff_throttle_max, 0.9)
            or body.accel_u >= _RISING_SHARE * limits.wp_accel_z_m_s2
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


class Hold:
    """Come to rest and stay (as LOITER with its sticks centred, by the position controller)."""

    done = False

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self._up_m = flight.control.stopping_point()[2]

    def step(self) -> None:
        """Hold position and altitude."""
        control = self._flight.control
        control.update()
        control.shape_rest()
        control.shape_altitude(self._up_m)
        self._flight.heading.update()


class GoTo:
    """Fly to a place (ModeGuided::pos_control_run, AC_PosControl::input_pos_xyz)."""

    def __init__(self, flight: Flight, place: Vector) -> None:
        self._flight = flight
        self.place = place
        self.done = False
        flight.heading.use_default()

    def step(self) -> None:
        """Move the target towards the place, and the copter after it."""
        flight = self._flight
        flight.control.update()
        flight.control.shape_to(self.place)
        flight.heading.update()
        n, e, u = self.place
        body = flight.body
        self.done = hypot(body.n - n, body.e - e, body.u - u) <= flight.limits.wp_radius_m


class Landing:
    """Descend, slowly from LAND_ALT_LOW on, until the land detector is sure; then spool down and disarm."""

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self.done = False
        self._still_s = 0.0
        limits = flight.limits
        flight.control.set_speeds(limits.wp_speed_m_s, limits.wp_speed_up_m_s, limits.wp_speed_down_m_s)
        flight.heading.hold()

    def step(self) -> None:
        """Descend one step (Mode::land_run_vertical_control)."""
        flight = self._flight
        limits, body, control = flight.limits, flight.body, flight.control
        control.update()
        control.shape_rest()
        low = max(limits.land_altitude_low_m, 1.0)
        slowest = abs(limits.land_speed_m_s)
        fastest = max(limits.land_speed_high_m_s or control.speed_down, slowest)
        rate = sqrt_controller(low - body.u, limits.position_z_p, control.accel_z_max, body.dt)
        control.shape_climb(clamp(rate, -fastest, -slowest))
        flight.heading.update()
        self._still_s = self._still_s + body.dt if body.on_ground and control.throttle <= 0 else 0.0
        self.done = self._still_s >= _LANDED_AFTER_S + limits.spool_s


class Return:
    """RTL: climb, fly home, wait above it, land."""

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self.done = False
        limits, navigation = flight.limits, flight.navigation
        navigation.start(limits.rtl_speed_m_s)
        start = navigation.destination
        self._up_m = self._return_altitude(start)
        navigation.fly_straight((start[0], start[1], self._up_m))
        navigation.then_straight((0.0, 0.0, self._up_m))
        flight.heading.hold()
        self._run = self._climb
        self._wait_s = 0.0
        self._landing: Landing | None = None

    def _return_altitude(self, start: Vector) -> float:
        """Altitude to return at (ModeRTL::compute_return_target)."""
        limits = self._flight.limits
        now = self._flight.body.u
        lowest = max(_LOWEST_RETURN_M, now + max(0.0, limits.rtl_climb_min_m))
        up = max(limits.rtl_altitude_m, lowest)
        if limits.rtl_cone_slope >= _SHALLOWEST_CONE:
            up = min(up, max(hypot(start[0], start[1]) * limits.rtl_cone_slope, lowest))
        # Altitudes are whole centimetres on board: some millimetres are always left to climb.
        return max(up, now, start[2] + _ROUNDING_M)

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
            self._wait_s = self._flight.limits.rtl_loiter_s
            self._run = self._wait

    def _wait(self) -> None:
        self._navigate()
        self._wait_s -= self._flight.body.dt
        if self._wait_s <= 0:
            self._landing = Landing(self._flight)
            self._run = self._land

    def _land(self) -> None:
        assert self._landing is not None
        self._landing.step()
        self.done = self._landing.done
