"""What a copter can be doing: ArduCopter's modes and their submodes, and the simplest of them."""

from __future__ import annotations

from flight_replay.simulator.dynamics.snapshot_part import SnapshotPart
from flight_replay.simulator.flight.flight_control import FlightControl


# Not a protocol: mypyc calls methods of a class directly, those of a protocol by their names.
class SubMode(SnapshotPart):
    """A part of a flight, ``done`` when it has come to its end; ``step`` flies the airframe."""

    done = False

    def step(self) -> None:
        """Fly one step."""
        raise NotImplementedError


class OnGround(SubMode):
    """On the ground; nothing moves."""

    def step(self) -> None:
        """Stay."""


class Hold(SubMode):
    """Come to rest and stay (as LOITER with its sticks centred, by the position controller)."""

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
