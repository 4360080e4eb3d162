"""Reads a list on board (mission or fence), several items under way: requests do not depend on each other."""

from __future__ import annotations

from collections.abc import Callable

from flight_replay.errors import VehicleError
from flight_replay.mavlink import MISSION_RESULTS, Message, dialect
from flight_replay.mission.items import MissionItem
from flight_replay.vehicle.link import timesync
from flight_replay.vehicle.link.port import Inbox, Port
from flight_replay.vehicle.protocol.mission_items import item_of

_QUIET_S = 12.0  # Without anything new this long (more than ArduPilot's 8 s for others), reading failed.
_BUSY_S = 0.5
_NAP_S = 0.2  # No wait is longer than this without attending.
MISSION = int(dialect.MAV_MISSION_TYPE_MISSION)
FENCE = int(dialect.MAV_MISSION_TYPE_FENCE)


class Reader:
    """One reading of the list that ``mission_type`` names; a mission includes home's slot, number 0.

    ``while_waiting`` is called again and again meanwhile, for whoever has other things to watch.
    """

    def __init__(
        self,
        port: Port,
        *,
        as_int: bool,
        mission_type: int = MISSION,
        while_waiting: Callable[[], None] = lambda: None,
    ) -> None:
        self._type, self._attend = mission_type, while_waiting
        self._port, self._trip, self._as_int = port, port.trip, as_int
        self._found: dict[int, MissionItem] = {}
        self._asked_s: dict[int, float] = {}
        self._first_asked: dict[int, float] = {}

    def read(self) -> list[MissionItem]:
        """All items, home's slot first; none if the vehicle has none.

        Raises:
            VehicleError: The vehicle does not answer, or refuses.
        """
        kinds = ("MISSION_COUNT", "MISSION_ITEM_INT", "MISSION_ITEM", "MISSION_ACK", timesync.KIND)
        with self._port.inbox(*kinds) as inbox:
            count = self._count(inbox)
            self._collect(inbox, count)
        self._port.send(
            dialect.MAVLink_mission_ack_message(
                self._port.system, self._port.component, dialect.MAV_MISSION_ACCEPTED, self._type
            )
        )
        return [self._found[seq] for seq in range(count)]

    def _count(self, inbox: Inbox) -> int:
        port, end_s = self._port, self._port.now_s() + _QUIET_S
        refusal = ""
        while port.now_s() < end_s:
            port.send(dialect.MAVLink_mission_request_list_message(port.system, port.component, self._type))
            asked_s = port.now_s()
            while (message := self._next(inbox, asked_s + self._trip.again_s)) is not None:
                if timesync.learn(port, message):
                    continue
                if message.get_type() == "MISSION_COUNT" and self._is_ours(message):
                    self._trip.took(port.now_s() - asked_s)
                    return int(message.count)
                if message.get_type() == "MISSION_ACK" and message.type != dialect.MAV_MISSION_ACCEPTED:
                    refusal = f": {MISSION_RESULTS.get(message.type, message.type)}"
                    inbox.get(_BUSY_S)
            self._trip.lost()
            timesync.ping(port)
        raise VehicleError(
            f"the vehicle did not tell its mission within {_QUIET_S:.0f} s{refusal}; check the link"
        )

    def _next(self, inbox: Inbox, until_s: float) -> Message | None:
        """The next message, attending while none comes; None if none comes by then."""
        while True:
            self._attend()
            left_s = until_s - self._port.now_s()
            message = inbox.get(min(left_s, _NAP_S))
            if message is not None or left_s <= _NAP_S:
                return message

    def _collect(self, inbox: Inbox, count: int) -> None:
        progress_s = self._port.now_s()
        while len(self._found) < count:
            if self._port.now_s() - progress_s > _QUIET_S:
                missing = min(set(range(count)) - self._found.keys())
                raise VehicleError(
                    f"the vehicle did not send mission item {missing} within {_QUIET_S:.0f} s; check the link"
                )
            self._ask(count)
            message = self._next(inbox, self._port.now_s() + self._trip.again_s / 4)
            while message is not None:
                if self._take(message, count):
                    progress_s = self._port.now_s()
                    self._ask(count)
                message = inbox.get(0.0)

    def _ask(self, count: int) -> None:
        """Keep a window of requests under way, asking again for those that are overdue."""
        now_s = self._port.now_s()
        missing = [seq for seq in range(count) if seq not in self._found][: self._trip.window]
        for seq in missing:
            if now_s - self._asked_s.get(seq, float("-inf")) < self._trip.again_s:
                continue
            if seq in self._asked_s:
                self._trip.lost()
                timesync.ping(self._port)
                self._request_other(seq)
            self._asked_s[seq] = now_s
            self._first_asked.setdefault(seq, now_s)
            self._request(seq, as_int=self._as_int)

    def _request_other(self, seq: int) -> None:
        """Ask for integers too: what the vehicle can do may only not have been heard."""
        if not self._as_int:
            self._request(seq, as_int=True)

    def _request(self, seq: int, *, as_int: bool) -> None:
        port = self._port
        kind = (
            dialect.MAVLink_mission_request_int_message if as_int else dialect.MAVLink_mission_request_message
        )
        port.send(kind(port.system, port.component, seq, self._type))

    def _take(self, message: Message, count: int) -> bool:
        """Whether the message brought an item that was missing."""
        if timesync.learn(self._port, message):
            return False
        kind = message.get_type()
        wanted = ("MISSION_ITEM_INT",) if self._as_int else ("MISSION_ITEM", "MISSION_ITEM_INT")
        if kind not in wanted or not self._is_ours(message) or message.seq >= count:
            return False
        if message.seq in self._found or message.seq not in self._asked_s:
            return False
        if self._asked_s[message.seq] == self._first_asked[message.seq]:
            self._trip.took(self._port.now_s() - self._asked_s[message.seq])
        self._found[message.seq] = item_of(message)
        return True

    def _is_ours(self, message: Message) -> bool:
        """Whether a message is about the list that is read."""
        return bool(getattr(message, "mission_type", MISSION) == self._type)
