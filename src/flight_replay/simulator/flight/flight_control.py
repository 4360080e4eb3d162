"""The airframe and the controllers that fly it.

Metres north, east, up of where the vehicle was armed, which is home unless a station moves it.
"""

from __future__ import annotations

from dataclasses import dataclass

from flight_replay.simulator.dynamics.airframe import Airframe
from flight_replay.simulator.dynamics.auto_yaw import AutoYaw
from flight_replay.simulator.dynamics.limits import Limits
from flight_replay.simulator.dynamics.position_control import PositionControl
from flight_replay.simulator.dynamics.snapshot_part import SnapshotPart
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.navigation.waypoint_navigation import WaypointNavigation


@dataclass(slots=True)
class FlightControl(SnapshotPart):
    """What the submodes share: the airframe, its controllers and the limits."""

    limits: Limits
    airframe: Airframe
    control: PositionControl
    navigation: WaypointNavigation
    auto_yaw: AutoYaw
    home: Vector = (0.0, 0.0, 0.0)
    """Where RTL lands, and what its altitudes count from."""
    arming_wait_s: float = 0.0
    """What is left of the delay between arming and spooling up (ARMING_DELAY_SEC)."""

    @property
    def position(self) -> Vector:
        """Position of the airframe."""
        return self.airframe.n, self.airframe.e, self.airframe.u

    def use_step(self, dt: float) -> None:
        """Use steps of another duration from now on."""
        self.airframe.use_step(dt)
        self.control.use_step(dt)

    def use_limits(self, limits: Limits) -> None:
        """Use other limits from now on."""
        self.limits = limits
        for part in (self.airframe, self.control, self.navigation, self.auto_yaw):
            part.use_limits(limits)
