"""One replay of a few waypoints on a built-in copter, over a ``FaultLink``: the outcome, and the truth."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

from flight_replay import supervisor, vehicle
from flight_replay.errors import FlightReplayError
from flight_replay.events import Event, LinkLost, LinkRestored, ReturnCommanded
from flight_replay.mission.items import Mission, waypoint
from flight_replay.simulator.autopilot.faults import Faults
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.server import launch
from flight_replay.supervisor import Deadlines, FlightRecord, Plan
from flight_replay.vehicle import preflight
from tests.helpers.fault_link import FaultLink, Message, Trip, Weather, fault_link

START = Start(47.397742, 8.545594, 488.0)
ROUTE = Mission(tuple(waypoint(47.397742 + 9e-5 * i, 8.545594, 12.0) for i in range(1, 31)))
UP_M = 8.0
RTL, AUTO = 6, 3
DEADLINES = Deadlines(
    prearm_s=60.0,
    arm_s=30.0,
    mode_s=40.0,
    no_climb_s=20.0,
    min_wall_s=3.0,
    give_up_wall_s=8.0,
    rtl_wall_s=6.0,
)


@dataclass
class Outcome:
    """What the program would say, and what was seen on the link."""

    link: FaultLink
    events: list[Event] = field(default_factory=list)
    record: FlightRecord | None = None
    error: str | None = None
    wall_s: float = 0.0

    @property
    def line(self) -> str | None:
        """The one line of an exit status of 1; None for 0."""
        return self.error or (self.record.problem if self.record else None)

    @property
    def rtl_confirmed(self) -> bool:
        """Whether RTL was commanded and confirmed."""
        return ReturnCommanded(True) in self.events

    @property
    def link_losses(self) -> list[Event]:
        """Losses and returns of the link, in order."""
        return [event for event in self.events if isinstance(event, LinkLost | LinkRestored)]

    def modes_asked(self) -> list[int]:
        """The modes that reached the vehicle as wishes, in order, repeats left out."""
        asked: list[int] = []
        for message in self.link.to_vehicle:
            mode = mode_of(message)
            if mode is not None and asked[-1:] != [mode]:
                asked.append(mode)
        return asked

    def was_armed(self) -> bool:
        """Whether the vehicle ever said that it is armed."""
        return any(
            message.get_type() == "HEARTBEAT" and message.get_srcSystem() == 1 and message.base_mode & 128
            for message in self.link.from_vehicle
        )


def mode_of(message: Message) -> int | None:
    """The mode that a message asks for, if it does."""
    if message.get_type() == "COMMAND_LONG" and message.command == 176:
        return int(message.param2)
    return int(message.custom_mode) if message.get_type() == "SET_MODE" else None


def replay(
    faults: Faults | None = None,
    weather: Weather | None = None,
    *trips: Trip,
    speedup: float = 20.0,
    duration_s: float = 12.0,
    connect_s: float = 8.0,
    seed: int = 1,
    **parameters: float,
) -> Outcome:
    """Connect, check, upload, fly and return, as the command line does; ``parameters`` are the vehicle's."""
    with (
        launch.run(START, speedup=speedup, faults=faults, parameters=parameters) as running,
        fault_link(running.connection, weather, trips, seed) as link,
    ):
        outcome = Outcome(link)
        began_s = time.monotonic()
        try:
            outcome.record = _fly(outcome, speedup, duration_s, connect_s)
        except FlightReplayError as error:
            outcome.error = str(error)
        outcome.wall_s = time.monotonic() - began_s
        return outcome


class _Clock:
    def monotonic_s(self) -> float:
        return time.monotonic()


def _fly(outcome: Outcome, speedup: float, duration_s: float, connect_s: float) -> FlightRecord:
    listener = outcome.events.append
    with vehicle.connect(
        outcome.link.connection, listener=listener, speedup=speedup, limit_s=connect_s
    ) as connected:
        at = connected.wait_position(20.0, listener)
        preflight.check(connected.identity, ROUTE, at, takeoff_altitude_m=UP_M)
        connected.upload(ROUTE, listener)
        plan = Plan(mission=ROUTE, duration_s=duration_s, takeoff_altitude_m=UP_M, deadlines=DEADLINES)
        return supervisor.fly(connected, _Clock(), plan, listener)
