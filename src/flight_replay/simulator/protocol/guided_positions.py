"""GUIDED: places to fly to, as mission items with a special ``current`` and as DO_REPOSITION.

Sources: ArduCopter/mode_auto.cpp (do_guided), GCS_Mavlink.cpp (handle_command_int_do_reposition).
"""

from __future__ import annotations

from flight_replay.flight_modes import CopterMode
from flight_replay.mavlink import Message, dialect
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.dynamics.vector import Vector
from flight_replay.simulator.flight.guided import GuidedTarget
from flight_replay.simulator.mission.stored_items import ItemRejected, to_stored_item
from flight_replay.simulator.protocol.channel import Sender
from flight_replay.simulator.protocol.command_int import ACCEPTED, DENIED, FAILED, CommandInt

_CHANGE_MODE = 1  # MAV_DO_REPOSITION_FLAGS_CHANGE_MODE


def item(autopilot: Autopilot, message: Message) -> int:
    """A mission item with current 2 (fly there) or 3 (change altitude); returns a MAV_MISSION_RESULT.

    ArduCopter accepts a change of altitude, and does nothing (handle_change_alt_request).
    """
    try:
        target = to_stored_item(message)
    except ItemRejected as refused:
        return refused.result
    if message.current == 3:
        return int(dialect.MAV_MISSION_ACCEPTED)
    position_m = autopilot.ekf_frame.position_of(target.lat_e7, target.lon_e7, target.alt_m, target.frame)
    if (
        autopilot.mode != CopterMode.GUIDED
        or target.command != dialect.MAV_CMD_NAV_WAYPOINT
        or position_m is None
        or not _fly_to(autopilot, position_m)
    ):
        return int(dialect.MAV_MISSION_ERROR)
    return int(dialect.MAV_MISSION_ACCEPTED)


def _fly_to(autopilot: Autopilot, position_m: Vector) -> bool:
    """Fly to a position, unless it is outside the fence; on the ground it is accepted, and nothing moves."""
    if not autopilot.allows_target(position_m):
        return False
    if autopilot.armed and not autopilot.flight.landed:
        autopilot.flight.follow(GuidedTarget(position_m=position_m))
    return True


def reposition(autopilot: Autopilot, command: CommandInt, sender: Sender) -> int:
    """DO_REPOSITION: fly to a location, entering GUIDED if asked to."""
    changes = int(command.params[1]) & _CHANGE_MODE
    if autopilot.mode != CopterMode.GUIDED and not changes:
        return DENIED
    position_m = autopilot.ekf_frame.position_of(command.x, command.y, command.z, command.frame)
    if position_m is None or (command.x == 0 and command.y == 0):
        return DENIED
    if not autopilot.allows_target(position_m) or not autopilot.request_mode(CopterMode.GUIDED):
        return FAILED
    _fly_to(autopilot, position_m)
    return ACCEPTED
