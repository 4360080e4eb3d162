"""What a copter can be doing, and the simplest of it: standing, holding, going somewhere.

A phase's ``step`` flies the airframe one step. Metres north, east, up of home.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot
from typing import Protocol

from flight_replay.simulator.airframe import Airframe
from flight_replay.simulator.heading import Heading
from flight_replay.simulator.limits import Limits
from flight_replay.simulator.path_limits import Vector
from flight_replay.simulator.position_control import PositionControl
from flight_replay.simulator.wpnav import WaypointNavigation


@dataclass(slots=True)
class Flight:
    """What phases share: the airframe, its controllers and the parameters."""

    limits: Limits
    body: Airframe
    control: PositionControl
    navigation: WaypointNavigation
    heading: Heading
    arming_wait_s: float = 0.0
    """What is left of the pause between arming and spooling up (ARMING_DELAY_SEC)."""

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

    @property
    def done(self) -> bool:
        """Whether it has come to its end."""

    def step(self) -> None:
        """Fly one step."""


class Standing:
    """On the ground; nothing moves."""

    done = False

    def step(self) -> None:
        """Stand."""


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
