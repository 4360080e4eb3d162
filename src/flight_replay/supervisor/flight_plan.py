"""What the supervisor flies, its deadlines, and the record that it returns."""

from __future__ import annotations

from dataclasses import dataclass, field

from flight_replay.logs.track import Track
from flight_replay.mission.items import Mission


@dataclass(frozen=True, slots=True, kw_only=True)
class Deadlines:
    """How long each phase may take: seconds of vehicle time, or wall-clock time where the name says so."""

    prearm_s: float = 180.0
    mode_s: float = 15.0
    arm_s: float = 60.0
    no_climb_s: float = 25.0
    no_progress_s: float = 60.0
    min_wall_s: float = 5.0
    """However fast the vehicle's clock runs, no phase times out earlier than this."""
    link_lost_wall_s: float = 4.0
    """Without data for so long, the link counts as lost."""
    give_up_wall_s: float = 30.0
    """Without data for so long, the flight ends."""
    rtl_wall_s: float = 8.0
    """How long RTL is requested after an error or Ctrl-C, which has to end the program within 10 s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """A flight: ``duration_s`` is vehicle time in AUTO, None for the whole mission."""

    mission: Mission
    duration_s: float | None = 60.0
    takeoff_altitude_m: float = 30.0
    land: bool = False
    deadlines: Deadlines = field(default_factory=Deadlines)

    @property
    def last_seq(self) -> int:
        """Sequence number of the final waypoint."""
        return self.mission.waypoints[-1][0]


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightRecord:
    """How a flight that reached AUTO went; times are seconds of the vehicle's clock.

    ``ended`` is "duration", "final waypoint", "mission complete", "pilot", "failsafe", "link lost",
    "reboot", "disarmed", "mission changed" or "no progress"; ``problem`` is None if the flight ended
    as planned, else one sentence. ``reached`` holds (sequence number, time) of each item in the order
    reached, ``flown`` the positions reported in AUTO, ``auto_start_s`` the time when AUTO began.
    """

    waypoints_reached: int
    ended: str
    problem: str | None
    auto_start_s: float
    auto_s: float
    rtl_confirmed: bool
    landed: bool
    reached: tuple[tuple[int, float], ...]
    flown: Track
