"""The mission protocol as ArduPilot 4.6 implements it (MissionItemProtocol.cpp), in vehicle time.

Here are download and clearing, and the lists of fence and rally points, which are always empty.
Uploads are in ``mission_upload``.
"""

from __future__ import annotations

from collections.abc import Callable

from flight_replay.events import Severity
from flight_replay.mavlink import Message, dialect
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.mission.stored_items import item_float, item_int
from flight_replay.simulator.protocol import guided_positions
from flight_replay.simulator.protocol.channel import Sender
from flight_replay.simulator.protocol.mission_upload import MissionUpload, acknowledge

_MISSION = dialect.MAV_MISSION_TYPE_MISSION
_ALWAYS_EMPTY = frozenset({dialect.MAV_MISSION_TYPE_FENCE, dialect.MAV_MISSION_TYPE_RALLY})
_ACCEPTED, _ERROR = dialect.MAV_MISSION_ACCEPTED, dialect.MAV_MISSION_ERROR
_NO_SPACE, _DENIED = dialect.MAV_MISSION_NO_SPACE, dialect.MAV_MISSION_DENIED

MissionHandler = Callable[[Message, Sender], None]


class MissionProtocol:
    """Answers mission messages, by name in ``handlers``."""

    def __init__(self, autopilot: Autopilot) -> None:
        self._autopilot, self._store = autopilot, autopilot.store
        self._knows_item_int = autopilot.faults.mission.supports_item_int
        self._upload = upload = MissionUpload(autopilot)
        self._warned = False
        self.handlers: dict[str, MissionHandler] = {
            "MISSION_COUNT": self._for_mission(upload.count, self._other_count),
            "MISSION_ITEM": self._for_mission(self._item, _ERROR),
            "MISSION_WRITE_PARTIAL_LIST": self._for_mission(upload.write_partial, _ERROR),
            "MISSION_REQUEST_LIST": self._request_list,
            "MISSION_REQUEST": self._for_mission(self._request, _ERROR),
            "MISSION_CLEAR_ALL": self._for_mission(self._clear_all, _ACCEPTED),
        }
        if self._knows_item_int:
            self.handlers["MISSION_ITEM_INT"] = self.handlers["MISSION_ITEM"]
            self.handlers["MISSION_REQUEST_INT"] = self.handlers["MISSION_REQUEST"]

    def update(self) -> None:
        """Request items again, or time out, by the vehicle's clock."""
        self._upload.update()

    @staticmethod
    def _for_mission(handler: MissionHandler, other_lists: int | Callable[[Message], int]) -> MissionHandler:
        """Answer messages about fence and rally points with ``other_lists``; other types are UNSUPPORTED."""

        def handle(message: Message, sender: Sender) -> None:
            if message.mission_type == _MISSION:
                handler(message, sender)
                return
            result = int(dialect.MAV_MISSION_UNSUPPORTED)
            if message.mission_type in _ALWAYS_EMPTY:
                result = other_lists if isinstance(other_lists, int) else other_lists(message)
            acknowledge(sender, result, message.mission_type)

        return handle

    def _item(self, message: Message, sender: Sender) -> None:
        """An item of an upload; or a GUIDED target, as DroneKit and old stations send it.

        That has ``current`` 2, or 3 for a change of altitude.
        """
        if message.current in (2, 3):
            acknowledge(sender, guided_positions.item(self._autopilot, message))
        else:
            self._upload.item(message, sender)

    @staticmethod
    def _other_count(message: Message) -> int:
        return int(_ACCEPTED if message.count == 0 else _NO_SPACE)

    def _is_busy(self, sender: Sender) -> bool:
        """Deny a download while a station uploads."""
        if self._store.receiving:
            acknowledge(sender, _DENIED)
        return self._store.receiving

    def _request_list(self, message: Message, sender: Sender) -> None:
        if message.mission_type in _ALWAYS_EMPTY:
            self._send_count(sender, 0, message.mission_type)
        elif message.mission_type != _MISSION:
            acknowledge(sender, dialect.MAV_MISSION_UNSUPPORTED, message.mission_type)
        elif not self._is_busy(sender):
            self._send_count(sender, len(self._store), _MISSION)

    @staticmethod
    def _send_count(sender: Sender, count: int, mission_type: int) -> None:
        sender.channel.send(
            dialect.MAVLink_mission_count_message(sender.system, sender.component, count, mission_type)
        )

    def _request(self, message: Message, sender: Sender) -> None:
        if self._is_busy(sender):
            return
        item = self._store.read(message.seq)
        if item is None:
            self._send_count(sender, len(self._store), _MISSION)
            acknowledge(sender, _ERROR)
            return
        as_float = message.get_type() == "MISSION_REQUEST"
        if as_float and self._knows_item_int and not self._warned:
            self._warned = True
            self._autopilot.say(Severity.WARNING, "got MISSION_REQUEST; use MISSION_REQUEST_INT!")
        answer = item_float if as_float else item_int
        # ArduPilot compares the item's command, not its number, with the current number (get_item).
        current = item.command == self._autopilot.mission.seq
        sender.channel.send(
            answer(item, message.seq, current=current, system=sender.system, component=sender.component)
        )

    def _clear_all(self, message: Message, sender: Sender) -> None:
        cleared = not self._store.receiving and self._autopilot.mission.clear()
        if cleared:
            self._store.truncate(0)
        acknowledge(sender, _ACCEPTED if cleared else _ERROR)
