"""What a copter can be doing, and the simplest of it: standing, holding, going somewhere.

A phase's ``step`` flies the airframe one step. Metres north, east, up of home.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from flight_replay.simulator.dynamics.airframe import Airframe
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.position_control import PositionControl
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.dynamics.yaw import Heading
from flight_replay.simulator.navigation.waypoint_navigation import WaypointNavigation


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
