"""Somebody who moves home in flight: RTL goes there, and not to where the vehicle took off."""

from __future__ import annotations

from flight_replay.events import VehicleState
from flight_replay.geometry.geodesy import ground_distance_m
from flight_replay.supervisor.vehicle_interface import HomePosition

_MOVED_M, _HIGHER_M = 2.0, 1.0
_OFF_GROUND_M = 1.0  # Arming moves home as well, and may be told after the heartbeat that shows it.


class HomeMoves:
    """Where home is, as the vehicle tells whenever it is set."""

    def __init__(self) -> None:
        self._home: HomePosition | None = None
        self.moved_m = 0.0
        """How far home is from where the vehicle was armed, if it was moved in flight."""

    def told(self, home: HomePosition, armed_at: VehicleState | None, altitude_m: float) -> str:
        """What a person has to know of it, as a sentence; empty where home was not moved in flight.

        Args:
            home: as the vehicle tells it now.
            armed_at: where it was armed; None if it is not armed.
            altitude_m: how high it is above that.
        """
        before, self._home = self._home, home
        if armed_at is None or altitude_m < _OFF_GROUND_M:
            return ""
        higher_m = home.amsl_m - before.amsl_m if before else 0.0
        if ground_distance_m(before or armed_at, home) < _MOVED_M and abs(higher_m) < _HIGHER_M:
            return ""
        self.moved_m = ground_distance_m(armed_at, home)
        higher = heights = ""
        if abs(higher_m) >= _HIGHER_M:
            higher = f", {abs(higher_m):.0f} m {'higher' if higher_m > 0 else 'lower'} than it was"
            heights = ", and the heights of a mission are above it"
        return (
            f"home was moved to {self.moved_m:.0f} m from where the vehicle was armed{higher}: RTL goes there"
            f"{heights}; keep that place clear, or set home back with the ground station that moved it"
        )
