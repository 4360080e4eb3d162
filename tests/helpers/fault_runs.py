"""One replay of a few waypoints on the built-in copter over a ``FaultLink``."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

from flight_replay import supervisor, vehicle
from flight_replay.events import Event, LinkLost, LinkRestored, ReturnCommanded
from flight_replay.exceptions import FlightReplayError
from flight_replay.mavlink import dialect
from flight_replay.mission.items import Mission, waypoint
from flight_replay.simulator.autopilot.faults import Faults
from flight_replay.simulator.autopilot.location import Start
from flight_replay.simulator.server import launch
from flight_replay.supervisor import Deadlines, FlightRecord, Plan, WallClock
from flight_replay.vehicle import preflight
from tests.helpers.fault_link import FaultLink, Message, Trigger, fault_link
from tests.helpers.link_conditions import LinkConditions

START = Start(47.397742, 8.545594, 488.0)
ROUTE = Mission(tuple(waypoint(47.397742 + 9e-5 * i, 8.545594, 12.0) for i in range(1, 31)))
TAKEOFF_M = 8.0
DEADLINES = Deadlines(
    prearm_s=60.0,
    arm_s=30.0,
    mode_s=40.0,
    no_climb_s=20.0,
    min_wall_s=8.0,
    give_up_wall_s=8.0,
    rtl_wall_s=15.0,
)


@dataclass
class FaultRun:
    """What the program would report, and the messages on the link."""

    link: FaultLink
    events: list[Event] = field(default_factory=list)
    record: FlightRecord | None = None
    error: str | None = None
    wall_s: float = 0.0

    @property
    def line(self) -> str | None:
        """The error message of an exit status of 1; None for 0."""
        return self.error or (self.record.problem if self.record else None)

    @property
    def rtl_confirmed(self) -> bool:
        """Whether RTL was commanded and confirmed."""
        return ReturnCommanded(True) in self.events

    @property
    def link_events(self) -> list[Event]:
        """Losses and returns of the link, in order."""
        return [event for event in self.events if isinstance(event, LinkLost | LinkRestored)]

    def modes_requested(self) -> list[int]:
        """The modes requested of the vehicle, in order, without repetitions."""
        requested: list[int] = []
        for message in self.link.to_vehicle:
            mode = requested_mode(message)
            if mode is not None and requested[-1:] != [mode]:
                requested.append(mode)
        return requested

    def was_armed(self) -> bool:
        """Whether a heartbeat of the vehicle ever showed it armed."""
        heartbeats = (
            m for m in self.link.from_vehicle if m.get_type() == "HEARTBEAT" and m.get_srcSystem() == 1
        )
        return any(m.base_mode & dialect.MAV_MODE_FLAG_SAFETY_ARMED for m in heartbeats)


def requested_mode(message: Message) -> int | None:
    """The mode that a message requests; None if it is another message."""
    if message.get_type() == "COMMAND_LONG" and message.command == dialect.MAV_CMD_DO_SET_MODE:
        return int(message.param2)
    return int(message.custom_mode) if message.get_type() == "SET_MODE" else None


def replay(
    faults: Faults | None = None,
    conditions: LinkConditions | None = None,
    *triggers: Trigger,
    speedup: float = 10.0,
    duration_s: float = 12.0,
    connect_s: float = 30.0,
    seed: int = 1,
    **parameters: float,
) -> FaultRun:
    """Connect, check, upload, fly and return, as the command line does; ``parameters`` are the vehicle's."""
    # At speedup 10 the ten seconds after which it disarms on the ground are one second here.
    stays_armed = {"DISARM_DELAY": 0.0}
    with (
        launch.run(START, speedup=speedup, faults=faults, parameters=stays_armed | parameters) as running,
        fault_link(running.connection, conditions, triggers, seed) as link,
    ):
        run = FaultRun(link)
        began_s = time.monotonic()
        try:
            run.record = _fly(run, speedup, duration_s, connect_s)
        except FlightReplayError as error:
            run.error = str(error)
        run.wall_s = time.monotonic() - began_s
        return run


def _fly(run: FaultRun, speedup: float, duration_s: float, connect_s: float) -> FlightRecord:
    listener = run.events.append
    with vehicle.connect(
        run.link.connection, listener=listener, speedup=speedup, limit_s=connect_s
    ) as connected:
        state = connected.wait_position(60.0, listener)
        preflight.check(connected.identity, ROUTE, state, takeoff_altitude_m=TAKEOFF_M)
        connected.upload(ROUTE, listener)
        plan = Plan(mission=ROUTE, duration_s=duration_s, takeoff_altitude_m=TAKEOFF_M, deadlines=DEADLINES)
        return supervisor.fly(connected, WallClock(), plan, listener)
