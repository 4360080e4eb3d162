"""What a copter can be doing: ArduCopter's modes and their submodes, and the simplest of them."""

from __future__ import annotations

from typing import Protocol

from flight_replay.simulator.flight.flight_control import FlightControl


class SubMode(Protocol):
    """A part of a flight; ``step`` flies the airframe."""

    @property
    def done(self) -> bool:
        """Whether it has come to its end."""

    def step(self) -> None:
        """Fly one step."""


class OnGround:
    """On the ground; nothing moves."""

    done = False

    def step(self) -> None:
        """Stay."""


class Hold:
    """Come to rest and stay (as LOITER with its sticks centred, by the position controller)."""

    done = False

    def __init__(self, flight: FlightControl) -> None:
        self._flight = flight
        self._up_m = flight.control.stopping_point()[2]

    def step(self) -> None:
        """Hold position and altitude."""
        control = self._flight.control
        control.update()
        control.input_stop_xy()
        control.input_altitude(self._up_m)
        self._flight.auto_yaw.update()
