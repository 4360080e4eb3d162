"""An upload of mission items as ArduPilot 4.6 receives it (MissionItemProtocol.cpp), in vehicle time.

Items are requested one by one with MISSION_REQUEST, again after a second without an answer; an
upload without items for 8 seconds is cancelled. While one station uploads, others are denied.
"""

from __future__ import annotations

from dataclasses import dataclass

from flight_replay.events import Severity
from flight_replay.mavlink import Message, dialect
from flight_replay.simulator.autopilot.autopilot import Autopilot
from flight_replay.simulator.mission.local_items import DO_JUMP
from flight_replay.simulator.mission.store import CAPACITY
from flight_replay.simulator.mission.stored_items import ItemRejected, StoredItem, to_stored_item
from flight_replay.simulator.protocol.channel import Sender

REQUEST_RETRY_S = 1.0
TIMEOUT_S = 8.0
_ACCEPTED, _ERROR = dialect.MAV_MISSION_ACCEPTED, dialect.MAV_MISSION_ERROR


def acknowledge(sender: Sender, result: int, mission_type: int = 0) -> None:
    """MISSION_ACK to a station."""
    sender.channel.send(
        dialect.MAVLink_mission_ack_message(sender.system, sender.component, result, mission_type)
    )


@dataclass(slots=True)
class _Transfer:
    """An upload in progress: the sender, the item that is requested, and since when."""

    sender: Sender
    next_seq: int
    last_seq: int
    received_s: float
    requested_s: float


class MissionUpload:
    """At most one upload at a time into the autopilot's mission store."""

    def __init__(self, autopilot: Autopilot) -> None:
        self._autopilot, self._store = autopilot, autopilot.store
        self._faults = autopilot.faults.mission
        self._capacity = min(CAPACITY, self._faults.capacity)
        self._warned = False
        self._end()

    def _end(self) -> None:
        self._transfer: _Transfer | None = None
        self._store.receiving = False

    def update(self) -> None:
        """Request the item again, or time out."""
        transfer, now_s = self._transfer, self._autopilot.time_s
        if transfer is None:
            return
        if now_s - transfer.received_s > TIMEOUT_S:
            self._end()
            self._autopilot.say(Severity.WARNING, "Mission upload timeout")
            acknowledge(transfer.sender, dialect.MAV_MISSION_OPERATION_CANCELLED)
        elif now_s - transfer.requested_s > REQUEST_RETRY_S:
            self._request(transfer)

    def count(self, message: Message, sender: Sender) -> None:
        """MISSION_COUNT begins an upload, or begins the station's own upload again."""
        if self._transfer is not None and not self._transfer.sender.is_same_station(sender):
            acknowledge(sender, dialect.MAV_MISSION_DENIED)
        elif message.count > self._capacity:
            acknowledge(sender, dialect.MAV_MISSION_NO_SPACE)
            self._autopilot.say(Severity.WARNING, f"Only {self._capacity} items are supported")
        else:
            self._store.truncate(message.count)
            self._begin(sender, 0, message.count - 1)

    def write_partial(self, message: Message, sender: Sender) -> None:
        """MISSION_WRITE_PARTIAL_LIST begins an upload of some items."""
        if 0 <= message.start_index <= message.end_index <= len(self._store):
            self._begin(sender, message.start_index, message.end_index)
        else:
            self._autopilot.say(Severity.WARNING, "Flight plan update rejected")
            acknowledge(sender, _ERROR)

    def _begin(self, sender: Sender, first_seq: int, last_seq: int) -> None:
        now_s = self._autopilot.time_s
        self._transfer = _Transfer(sender, first_seq, last_seq, now_s, now_s)
        self._store.receiving = True
        self._request_or_complete(self._transfer)

    def _request_or_complete(self, transfer: _Transfer) -> None:
        if transfer.next_seq <= transfer.last_seq:
            self._request(transfer)
            return
        self._end()
        self._autopilot.trigger("upload")
        self._autopilot.say(Severity.INFO, "Flight plan received")
        acknowledge(transfer.sender, self._faults.result_of_upload)

    def _request(self, transfer: _Transfer) -> None:
        transfer.requested_s = self._autopilot.time_s
        sender = transfer.sender
        sender.channel.send(
            dialect.MAVLink_mission_request_message(sender.system, sender.component, transfer.next_seq)
        )

    def item(self, message: Message, sender: Sender) -> None:
        """MISSION_ITEM or MISSION_ITEM_INT: stored if it is the one that was requested."""
        if message.get_type() == "MISSION_ITEM" and self._faults.supports_item_int and not self._warned:
            self._warned = True
            self._autopilot.say(Severity.WARNING, "got MISSION_ITEM; GCS should send MISSION_ITEM_INT")
        transfer = self._transfer
        if transfer is None:
            acknowledge(sender, _ERROR)
        elif message.seq != transfer.next_seq:
            acknowledge(sender, dialect.MAV_MISSION_INVALID_SEQUENCE)
        elif not transfer.sender.is_same_station(sender):
            acknowledge(sender, dialect.MAV_MISSION_DENIED)
        else:
            self._receive_item(message, transfer)

    def _receive_item(self, message: Message, transfer: _Transfer) -> None:
        """Store an item and request the next; one that is rejected ends the upload."""
        result = self._store_item(message, transfer)
        if result != _ACCEPTED:
            self._end()
            acknowledge(transfer.sender, result)
            return
        transfer.received_s = self._autopilot.time_s
        transfer.next_seq += 1
        self._request_or_complete(transfer)

    def _store_item(self, message: Message, transfer: _Transfer) -> int:
        refused = self._faults.result_of_item.get(message.seq)
        if refused is not None:
            return refused
        try:
            item = to_stored_item(message)
        except ItemRejected as reason:
            return reason.result
        if item.command == DO_JUMP and not self._jump_target_exists(item, transfer):
            return int(_ERROR)
        return int(_ACCEPTED if self._store.write(message.seq, item) else _ERROR)

    def _jump_target_exists(self, item: StoredItem, transfer: _Transfer) -> bool:
        target = int(item.params[0])
        return target != 0 and (target < len(self._store) or target <= transfer.last_seq)
