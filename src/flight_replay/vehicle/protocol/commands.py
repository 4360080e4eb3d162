"""Asks the vehicle for modes, arming and take-off; its answers come as news.

ArduPilot answers COMMAND_LONG DO_SET_MODE since 2017; ArduCopter 3.3 only knows the SET_MODE
message, which nobody answers: there the heartbeat alone shows what came of it.

Behind each request an echo is asked for (TIMESYNC): one that comes back without an answer shows
that request or answer got lost, and not only late. ArduCopter 3.3 sends none.
"""

from __future__ import annotations

from flight_replay.mavlink import RESULTS, Message, dialect
from flight_replay.supervisor.vehicle_interface import Request, RequestAck, RequestLost
from flight_replay.vehicle.link import timesync
from flight_replay.vehicle.link.port import Port, is_for_us

_SILENT_ASKS = 2  # After as many unanswered requests both ways of asking for a mode are used.
_MOST_ECHOES = 20  # An autopilot that sends none by then knows no TIMESYNC.
_REQUESTS = {
    dialect.MAV_CMD_DO_SET_MODE: Request.MODE,
    dialect.MAV_CMD_COMPONENT_ARM_DISARM: Request.ARM,
    dialect.MAV_CMD_NAV_TAKEOFF: Request.TAKEOFF,
}
_RUN_PREARM_CHECKS = 401
_CUSTOM_MODE = dialect.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED


def command(port: Port, number: int, *params: float) -> Message:
    """A COMMAND_LONG to the vehicle; parameters that are left out are 0."""
    values = (*params, *(0.0,) * (7 - len(params)))
    return dialect.MAVLink_command_long_message(port.system, port.component, number, 0, *values)


class Commands:
    """What can be asked for, and what came of it."""

    def __init__(self, port: Port) -> None:
        self._port = port
        self._command_sets_mode: bool | None = None
        self._unanswered = 0
        self._mode = 0
        self._pending: Request | None = None
        self._echoes: frozenset[int] = frozenset()
        self._echo_asked_s = 0.0

    def set_mode(self, mode: int) -> None:
        """Ask for a mode by its number."""
        self._mode = mode
        if self._command_sets_mode is not False:
            self._ask(Request.MODE, command(self._port, dialect.MAV_CMD_DO_SET_MODE, _CUSTOM_MODE, mode))
            self._unanswered += 1
        if self._command_sets_mode is False or self._unanswered > _SILENT_ASKS:
            self._send_set_mode()

    def _ask(self, request: Request, message: Message) -> None:
        self._pending, self._echoes = request, frozenset()
        self._port.send(message)
        self._ask_echo()

    def _ask_echo(self) -> None:
        self._echo_asked_s = self._port.now_s()
        self._echoes |= {timesync.ping(self._port)}

    def keep(self) -> None:
        """Ask for an echo again while neither it nor the answer to the last request has come."""
        wanted = self._pending is not None and len(self._echoes) < _MOST_ECHOES
        if wanted and self._port.now_s() - self._echo_asked_s >= self._port.trip.again_s:
            self._ask_echo()

    def echoed(self, message: Message) -> RequestLost | None:
        """The news in a TIMESYNC: what was asked before it was not answered."""
        request = self._pending
        if request is None or message.tc1 == 0 or message.ts1 not in self._echoes:
            return None
        self._pending = None
        return RequestLost(request)

    def _send_set_mode(self) -> None:
        self._port.send(dialect.MAVLink_set_mode_message(self._port.system, _CUSTOM_MODE, self._mode))

    def arm(self) -> None:
        """Ask to arm, with all checks."""
        self._ask(Request.ARM, command(self._port, dialect.MAV_CMD_COMPONENT_ARM_DISARM, 1))

    def take_off(self, altitude_m: float) -> None:
        """Ask to climb to ``altitude_m`` above home."""
        self._port.send(command(self._port, dialect.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, altitude_m))

    def report_prearm(self) -> None:
        """Ask for the reasons against arming; firmware that does not know this tells them now and then."""
        self._port.send(command(self._port, _RUN_PREARM_CHECKS))

    def answer(self, message: Message) -> RequestAck | None:
        """The news in a COMMAND_ACK; none where it is to somebody else, or not the last word."""
        if not is_for_us(message):
            return None
        request = _REQUESTS.get(message.command)
        if request is self._pending:
            self._pending = None
        if request is Request.MODE:
            self._unanswered = 0
            self._command_sets_mode = message.result != dialect.MAV_RESULT_UNSUPPORTED
            if not self._command_sets_mode:
                self._send_set_mode()
                return None
        if request is None or message.result == dialect.MAV_RESULT_IN_PROGRESS:
            return None
        accepted = message.result == dialect.MAV_RESULT_ACCEPTED
        return RequestAck(
            request, accepted, "" if accepted else RESULTS.get(message.result, str(message.result))
        )
