"""One recording followed in GUIDED on the built-in copter over a ``FaultLink``."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from flight_replay import supervisor, vehicle
from flight_replay.events import Event, VehicleState, combine_listeners
from flight_replay.exceptions import FlightReplayError
from flight_replay.flight_modes import CopterMode
from flight_replay.geometry.arrays import Floats
from flight_replay.geometry.flat_earth import FlatFrame
from flight_replay.simulator.autopilot.faults import Faults
from flight_replay.simulator.server import launch
from flight_replay.supervisor import FollowPlan, WallClock
from flight_replay.vehicle import following
from tests.helpers.fault_link import Message, Trigger, fault_link
from tests.helpers.fault_runs import DEADLINES, START, TAKEOFF_M, FaultRun
from tests.helpers.link_conditions import LinkConditions
from tests.helpers.supervised import RECORDED_S, s_curve

FRAME = FlatFrame(START.lat_deg, START.lon_deg)
REFERENCE = s_curve(FRAME, length_m=100.0, alt_m=12.0)
TOP_SPEED_M_S = float(np.linalg.norm(REFERENCE.velocities_m_s(REFERENCE.times_s(0.1)), axis=1).max())


@dataclass
class FollowRun(FaultRun):
    """What the program would report, the messages on the link, and where the copter was."""

    @property
    def targets(self) -> list[Message]:
        """The targets that move which the vehicle received."""
        return [m for m in self.link.to_vehicle if is_target(m)]

    def after_mode(self, mode: CopterMode) -> list[Message]:
        """What the vehicle received of us after its first heartbeat in a mode, but heartbeats and pings."""
        log = self.link.log
        left = next(i for i, (_, m) in enumerate(log) if is_in_mode(m, mode))
        return [m for to_vehicle, m in log[left:] if to_vehicle and m.get_type() not in _HARMLESS]

    def states(self) -> list[VehicleState]:
        """Positions received while following."""
        assert self.record is not None
        begin_s = self.record.auto_start_s
        end_s = begin_s + self.record.auto_s
        states = [event for event in self.events if isinstance(event, VehicleState)]
        return [state for state in states if begin_s <= state.time_s <= end_s]

    def off_path_m(self) -> Floats:
        """How far each position received while following is from the reference's path (n,)."""
        path_m = REFERENCE.positions_m(REFERENCE.times_s(0.02))
        states = self.states()
        lat_deg, lon_deg = np.array([(s.lat_deg, s.lon_deg) for s in states]).T
        north_m, east_m = FRAME.to_metres(lat_deg, lon_deg).T
        places_m = np.column_stack([north_m, east_m, [s.alt_m for s in states]])
        return np.array([np.linalg.norm(path_m - place, axis=1).min() for place in places_m])

    def speeds_m_s(self) -> Floats:
        """Speeds reported while following (n,)."""
        return np.array([np.linalg.norm(state.velocity_m_s) for state in self.states()])


_HARMLESS = frozenset({"HEARTBEAT", "TIMESYNC", "REQUEST_DATA_STREAM"})


def is_target(message: Message) -> bool:
    """Whether it is a target that moves."""
    return bool(message.get_type() == "SET_POSITION_TARGET_LOCAL_NED")


def is_in_mode(message: Message, mode: CopterMode) -> bool:
    """Whether it is a heartbeat of the copter in a mode."""
    return bool(
        message.get_type() == "HEARTBEAT" and message.get_srcSystem() == 1 and message.custom_mode == mode
    )


def follow(
    faults: Faults | None = None,
    conditions: LinkConditions | None = None,
    *triggers: Trigger,
    speedup: float = 10.0,
    duration_s: float = 20.0,
    max_error_m: float = 3.0,
    listener: Callable[[Event], None] = lambda _: None,
    seed: int = 1,
    **parameters: float,
) -> FollowRun:
    """Connect, fly to the beginning, follow and return, as the command line does.

    ``listener`` gets the events as well; ``parameters`` are the vehicle's.
    """
    own = {"DISARM_DELAY": 0.0} | parameters
    plan = FollowPlan(
        reference=REFERENCE,
        recorded_s=RECORDED_S,
        duration_s=duration_s,
        takeoff_altitude_m=TAKEOFF_M,
        max_error_m=max_error_m,
        deadlines=DEADLINES,
        speedup=speedup,
    )
    with (
        launch.run(START, speedup=speedup, faults=faults, parameters=own) as running,
        fault_link(running.connection, conditions, triggers, seed) as link,
    ):
        run = FollowRun(link)
        began_s = time.monotonic()
        hears = combine_listeners(run.events.append, listener)
        try:
            with vehicle.connect(link.connection, listener=hears, speedup=speedup) as connected:
                connected.wait_position(60.0, hears)
                plan = replace(plan, tuning=following.tuning_of(connected.identity))
                # They stay: this copter is not flown again.
                connected.set_known_parameters(following.parameters_for_following(connected))
                run.record = supervisor.fly(connected, WallClock(), plan, hears)
        except FlightReplayError as error:
            run.error = str(error)
        run.wall_s = time.monotonic() - began_s
        return run
