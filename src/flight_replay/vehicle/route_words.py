"""What places of a route are called in messages for people: waypoints of a mission, or times of a motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from flight_replay.geometry.arrays import Floats
from flight_replay.writing.counted import counted


class RouteWords(Protocol):
    """What a person is told of places on a route; ``seq`` is a waypoint's number, from 1 on."""

    @property
    def mode(self) -> str:
        """The mode in which the route is flown."""

    @property
    def beginning(self) -> str:
        """Where the route begins, such as "the first waypoint"."""

    def place(self, seq: int) -> str:
        """One of its places, such as "waypoint 7"."""

    def way(self, seq: int) -> str:
        """The way to that place, such as "the leg to waypoint 7"."""

    def extent(self, places: int) -> str:
        """What there is of it, such as "100 waypoints, "; may be empty."""


class MissionWords:
    """A mission is told of by its waypoints."""

    mode = "AUTO"
    beginning = "the first waypoint"

    def place(self, seq: int) -> str:
        """By its number."""
        return f"waypoint {seq}"

    def way(self, seq: int) -> str:
        """The leg."""
        return f"the leg to waypoint {seq}"

    def extent(self, places: int) -> str:
        """How many there are."""
        return f"{counted(places, 'waypoint')}, "


@dataclass(frozen=True, eq=False)
class MotionWords:
    """A motion that is followed is told of by its time: ``times_s`` (n,) of its outline's places."""

    times_s: Floats

    mode = "GUIDED"
    beginning = "the beginning of the motion"

    def place(self, seq: int) -> str:
        """When it is there."""
        return f"the motion at {self.times_s[seq - 1]:.0f} s"

    def way(self, seq: int) -> str:
        """The same, but for the straight way there."""
        return f"the way to {self.beginning}" if seq == 1 else self.place(seq)

    def extent(self, places: int) -> str:
        """Nothing: how many places are checked tells nobody anything."""
        return ""
