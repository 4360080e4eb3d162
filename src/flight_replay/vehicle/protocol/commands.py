"""Sends commands (flight mode, arming, take-off), and turns their acks into reports.

ArduPilot answers COMMAND_LONG DO_SET_MODE since 2017; ArduCopter 3.3 knows only the SET_MODE
message, which has no ack: there only the heartbeat shows the result.

A TIMESYNC request follows each command: its reply without an ack before it shows that the command
or its ack is lost, and not only late. ArduCopter 3.3 does not reply to TIMESYNC.
"""

from __future__ import annotations

from flight_replay.mavlink import RESULTS, Message, dialect
from flight_replay.supervisor.vehicle_interface import Request, RequestAck, RequestLost
from flight_replay.vehicle.link import timesync
from flight_replay.vehicle.link.vehicle_link import VehicleLink, is_for_us

_UNACKED_COMMANDS = 2  # After so many mode commands without an ack, SET_MODE is sent as well.
_MAX_PINGS = 20  # An autopilot that has not replied by then does not know TIMESYNC.
_REQUESTS = {
    dialect.MAV_CMD_DO_SET_MODE: Request.MODE,
    dialect.MAV_CMD_COMPONENT_ARM_DISARM: Request.ARM,
    dialect.MAV_CMD_NAV_TAKEOFF: Request.TAKEOFF,
}
_RUN_PREARM_CHECKS = 401
_CUSTOM_MODE = dialect.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED


def command_long(link: VehicleLink, command: int, *params: float) -> Message:
    """A COMMAND_LONG to the vehicle; parameters that are left out are 0."""
    values = (*params, *(0.0,) * (7 - len(params)))
    return dialect.MAVLink_command_long_message(link.system, link.component, command, 0, *values)


class CommandSender:
    """Sends commands, and reports their acks and losses."""

    def __init__(self, link: VehicleLink) -> None:
        self._link = link
        self._knows_mode_command: bool | None = None
        self._unacked = 0
        self._mode = 0
        self._pending: Request | None = None
        self._pings: frozenset[int] = frozenset()
        self._pinged_s = 0.0

    def set_mode(self, mode: int) -> None:
        """Command a flight mode by its number."""
        self._mode = mode
        if self._knows_mode_command is not False:
            command = command_long(self._link, dialect.MAV_CMD_DO_SET_MODE, _CUSTOM_MODE, mode)
            self._send(Request.MODE, command)
            self._unacked += 1
        if self._knows_mode_command is False or self._unacked > _UNACKED_COMMANDS:
            self._send_set_mode()

    def _send(self, request: Request, message: Message) -> None:
        self._pending, self._pings = request, frozenset()
        self._link.send(message)
        self._ping()

    def _ping(self) -> None:
        self._pinged_s = self._link.now_s()
        self._pings |= {timesync.ping(self._link)}

    def retry_ping(self) -> None:
        """Send another TIMESYNC while neither a reply nor the ack of the last command has come."""
        wanted = self._pending is not None and len(self._pings) < _MAX_PINGS
        if wanted and self._link.now_s() - self._pinged_s >= self._link.round_trip.retry_s:
            self._ping()

    def on_timesync(self, message: Message) -> RequestLost | None:
        """A TIMESYNC reply: the command sent before it was not acked."""
        # Of any of our pings, not the last alone: on a slow link the next one is sent before the reply comes.
        request = self._pending
        if request is None or message.tc1 == 0 or message.ts1 not in self._pings:
            return None
        self._pending = None
        return RequestLost(request)

    def _send_set_mode(self) -> None:
        self._link.send(dialect.MAVLink_set_mode_message(self._link.system, _CUSTOM_MODE, self._mode))

    def arm(self) -> None:
        """Command arming, with all pre-arm checks."""
        self._send(Request.ARM, command_long(self._link, dialect.MAV_CMD_COMPONENT_ARM_DISARM, 1))

    def take_off(self, altitude_m: float) -> None:
        """Command a take-off to ``altitude_m`` above home."""
        self._link.send(command_long(self._link, dialect.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, altitude_m))

    def change_speed(self, speed_m_s: float) -> None:
        """Command a ground speed, metres per second."""
        self._link.send(command_long(self._link, dialect.MAV_CMD_DO_CHANGE_SPEED, 1, speed_m_s))

    def run_prearm_checks(self) -> None:
        """Command the pre-arm checks; firmware that does not know this sends failures now and then."""
        self._link.send(command_long(self._link, _RUN_PREARM_CHECKS))

    def on_ack(self, message: Message) -> RequestAck | None:
        """A COMMAND_ACK: None if it is for another station, or not final."""
        if not is_for_us(message):
            return None
        request = _REQUESTS.get(message.command)
        if request is self._pending:
            self._pending = None
        if request is Request.MODE:
            self._unacked = 0
            self._knows_mode_command = message.result != dialect.MAV_RESULT_UNSUPPORTED
            if not self._knows_mode_command:
                self._send_set_mode()
                return None
        if request is None or message.result == dialect.MAV_RESULT_IN_PROGRESS:
            return None
        accepted = message.result == dialect.MAV_RESULT_ACCEPTED
        reason = "" if accepted else RESULTS.get(message.result, str(message.result))
        return RequestAck(request, accepted, reason)
