"""What the supervisor flies, its deadlines, and the record that it returns."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, field

from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.reference_motion import ReferenceMotion
from flight_replay.logs.track import Track
from flight_replay.mission.items import Mission
from flight_replay.supervisor.follower import Tuning


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
class FlightPlan:
    """What every flight has, however it is flown: a take-off, deadlines, and an end.

    With ``land`` the landing is waited for, before which RTL waits ``rtl_loiter_s`` over home, or over a
    rally point, which is at most ``rally_limit_m`` away.
    """

    takeoff_altitude_m: float = 30.0
    land: bool = False
    rtl_loiter_s: float = 5.0
    rally_limit_m: float = 0.0
    deadlines: Deadlines = field(default_factory=Deadlines)


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan(FlightPlan):
    """A mission flown in AUTO: ``duration_s`` is vehicle time in AUTO, None for the whole mission."""

    mission: Mission
    duration_s: float | None = 60.0

    @property
    def last_seq(self) -> int:
        """Sequence number of the final waypoint."""
        return self.mission.waypoints[-1][0]

    def waypoint_at(self, seq: int) -> tuple[int, int]:
        """Which waypoint the vehicle flies to at an item, counted from 1, and how many there are."""
        seqs = [each for each, _ in self.mission.waypoints]
        return min(bisect_left(seqs, seq) + 1, len(seqs)), len(seqs)


@dataclass(frozen=True, slots=True, kw_only=True)
class FollowPlan(FlightPlan):
    """A recording followed in GUIDED."""

    reference: ReferenceMotion
    recorded_s: float
    """When the last fix was recorded."""
    duration_s: float | None = 60.0
    """How much of the recording's time; None for all of it."""
    max_error_m: float = 3.0
    """The reference waits for a vehicle that is farther from it; three times that ends the flight."""
    tuning: Tuning = field(default_factory=Tuning)
    approach_m_s: float | None = None
    """The speed of the way to the recording's begin; None for the vehicle's own, ``speed_m_s``."""
    speed_m_s: float = 10.0
    speedup: float | None = None
    """That of a simulator, which is slowed down where this machine is too busy for it; None to leave its
    clock alone."""
    passes: int = 1
    """All but the last only teach the next one."""

    @property
    def end_s(self) -> float:
        """The recording's time at which the flight ends."""
        return self.recorded_s if self.duration_s is None else min(self.duration_s, self.recorded_s)

    @property
    def ended(self) -> str:
        """Why it ends there."""
        whole = self.duration_s is None or self.duration_s >= self.recorded_s
        return "recording complete" if whole else "duration"


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightRecord:
    """How a flight that reached AUTO, or the recording's begin, went; times are of the vehicle's clock."""

    waypoints_reached: int
    ended: str
    """Why it ended: "duration", "final waypoint", "mission complete", "recording complete", "pilot",
    "failsafe", "link lost", "reboot", "disarmed", "mission changed", "off course", "no progress",
    "internal error" or "interrupted"."""
    problem: str | None
    """None if the flight ended as planned, else one sentence."""
    auto_start_s: float
    """When AUTO, or following, began."""
    auto_s: float
    """How long it lasted."""
    rtl_confirmed: bool
    landed: bool
    reached: tuple[tuple[int, float], ...]
    """Sequence number and time of each item, in the order reached."""
    flown: Track
    """The positions reported in AUTO, or while following."""
    recording_s: Floats | None = None
    """The recording's time at each flown position (n,), None for a mission."""
