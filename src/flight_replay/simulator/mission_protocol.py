"""The mission protocol as ArduPilot 4.6 speaks it (MissionItemProtocol.cpp), in vehicle time.

Items are asked for one by one with MISSION_REQUEST, again after a second without an answer; an
upload that is silent for 8 seconds is cancelled. While one station uploads, others are denied.
Fence and rally points, which this copter has none of, are answered as empty lists.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from flight_replay.simulator.faults import MissionFaults
from flight_replay.simulator.mavlink import Message, Sender, dialect
from flight_replay.simulator.mission_items import (
    ItemRefused,
    StoredItem,
    item_float,
    item_int,
    stored,
)
from flight_replay.simulator.mission_store import CAPACITY, MissionStore

REQUEST_AGAIN_S = 1.0
CANCEL_S = 8.0
_WARNING, _INFO = 4, 6
_DO_JUMP = 177
_OTHER_LISTS = {dialect.MAV_MISSION_TYPE_FENCE, dialect.MAV_MISSION_TYPE_RALLY}


@dataclass(slots=True)
class _Upload:
    """An upload under way: who sends, what is asked next, and since when."""

    sender: Sender
    next_seq: int
    last_seq: int
    received_s: float
    requested_s: float


class MissionProtocol:
    """Answers mission messages; ``time_s`` is the vehicle's clock, ``say`` speaks to all stations."""

    def __init__(
        self,
        store: MissionStore,
        *,
        time_s: Callable[[], float],
        say: Callable[[int, str], None],
        may_clear: Callable[[], bool],
        current_seq: Callable[[], int],
        faults: MissionFaults,
    ) -> None:
        self._store, self._time_s, self._say = store, time_s, say
        self._may_clear, self._current_seq = may_clear, current_seq
        self._faults = faults
        self._upload: _Upload | None = None
        self._warned: set[str] = set()
        self.uploads = 0
        self.handlers: dict[str, Callable[[Message, Sender], None]] = {
            "MISSION_COUNT": self._count,
            "MISSION_ITEM": self._item,
            "MISSION_REQUEST_LIST": self._request_list,
            "MISSION_REQUEST": self._request,
            "MISSION_CLEAR_ALL": self._clear_all,
            "MISSION_WRITE_PARTIAL_LIST": self._write_partial,
        }
        if faults.knows_item_int:
            self.handlers |= {"MISSION_ITEM_INT": self._item, "MISSION_REQUEST_INT": self._request}

    @property
    def receiving(self) -> bool:
        """Whether an upload is under way."""
        return self._upload is not None

    def update(self) -> None:
        """Ask again, or give up, by the vehicle's clock."""
        upload, now_s = self._upload, self._time_s()
        if upload is None:
            return
        if now_s - upload.received_s > CANCEL_S:
            self._upload = None
            self._say(_WARNING, "Mission upload timeout")
            self._ack(upload.sender, dialect.MAV_MISSION_OPERATION_CANCELLED)
        elif now_s - upload.requested_s > REQUEST_AGAIN_S:
            self._ask(upload)

    def _ack(self, sender: Sender, result: int, mission_type: int = 0) -> None:
        sender.channel.send(
            dialect.MAVLink_mission_ack_message(sender.system, sender.component, result, mission_type)
        )

    def _is_elsewhere(self, message: Message, sender: Sender, answer: int) -> bool:
        """Whether the message is about a list that is not the mission; then it is answered here."""
        if message.mission_type == dialect.MAV_MISSION_TYPE_MISSION:
            return False
        result = answer if message.mission_type in _OTHER_LISTS else dialect.MAV_MISSION_UNSUPPORTED
        self._ack(sender, result, message.mission_type)
        return True

    def _is_busy(self, sender: Sender) -> bool:
        if self._upload is not None:
            self._ack(sender, dialect.MAV_MISSION_DENIED)
        return self._upload is not None

    def _count(self, message: Message, sender: Sender) -> None:
        empty = message.count == 0
        answer = dialect.MAV_MISSION_ACCEPTED if empty else dialect.MAV_MISSION_NO_SPACE
        if self._is_elsewhere(message, sender, answer):
            return
        if self._upload is not None and not self._upload.sender.is_same_station(sender):
            self._ack(sender, dialect.MAV_MISSION_DENIED)
        elif message.count > min(CAPACITY, self._faults.capacity):
            self._ack(sender, dialect.MAV_MISSION_NO_SPACE)
            self._say(_WARNING, f"Only {min(CAPACITY, self._faults.capacity)} items are supported")
        else:
            self._store.truncate(message.count)
            self._begin(sender, 0, message.count - 1)

    def _write_partial(self, message: Message, sender: Sender) -> None:
        if self._is_elsewhere(message, sender, dialect.MAV_MISSION_ERROR):
            return
        if not 0 <= message.start_index <= message.end_index <= len(self._store):
            self._say(_WARNING, "Flight plan update rejected")
            self._ack(sender, dialect.MAV_MISSION_ERROR)
        else:
            self._begin(sender, message.start_index, message.end_index)

    def _begin(self, sender: Sender, first_seq: int, last_seq: int) -> None:
        now_s = self._time_s()
        self._upload = _Upload(sender, first_seq, last_seq, now_s, now_s)
        self._ask_or_complete(self._upload)

    def _ask_or_complete(self, upload: _Upload) -> None:
        if upload.next_seq <= upload.last_seq:
            self._ask(upload)
            return
        self._upload = None
        self.uploads += 1
        self._say(_INFO, "Flight plan received")
        self._ack(upload.sender, self._faults.result_of_upload)

    def _ask(self, upload: _Upload) -> None:
        upload.requested_s = self._time_s()
        sender = upload.sender
        sender.channel.send(
            dialect.MAVLink_mission_request_message(sender.system, sender.component, upload.next_seq)
        )

    def _item(self, message: Message, sender: Sender) -> None:
        if self._is_elsewhere(message, sender, dialect.MAV_MISSION_ERROR):
            return
        try:
            item = stored(message)
        except ItemRefused as refused:
            self._refuse(message, sender, refused.result)
            return
        upload = self._expected(message, sender)
        if upload is None:
            return
        result = self._write(message.seq, item, upload)
        if result != dialect.MAV_MISSION_ACCEPTED:
            self._refuse(message, sender, result)
            return
        upload.received_s = self._time_s()
        upload.next_seq += 1
        self._ask_or_complete(upload)

    def _expected(self, message: Message, sender: Sender) -> _Upload | None:
        """The upload under way if this is the item it asked for; anything else is answered here."""
        if message.get_type() == "MISSION_ITEM" and self._faults.knows_item_int:
            self._warn_once("got MISSION_ITEM; GCS should send MISSION_ITEM_INT")
        upload = self._upload
        if upload is None:
            self._ack(sender, dialect.MAV_MISSION_ERROR)
            return None
        if message.seq != upload.next_seq:
            self._ack(sender, dialect.MAV_MISSION_INVALID_SEQUENCE)
            return None
        if not upload.sender.is_same_station(sender):
            self._ack(sender, dialect.MAV_MISSION_DENIED)
            return None
        return upload

    def _refuse(self, message: Message, sender: Sender, result: int) -> None:
        """A bad item ends the upload, if it is the one that was asked for."""
        if self._expected(message, sender) is not None:
            self._upload = None
            self._ack(sender, result)

    def _write(self, seq: int, item: StoredItem, upload: _Upload) -> int:
        refused = self._faults.result_of_item.get(seq)
        if refused is not None:
            return refused
        if item.command == _DO_JUMP:
            target = int(item.params[0])
            if target == 0 or (target >= len(self._store) and target > upload.last_seq):
                return int(dialect.MAV_MISSION_ERROR)
        done = self._store.write(seq, item)
        return int(dialect.MAV_MISSION_ACCEPTED if done else dialect.MAV_MISSION_ERROR)

    def _warn_once(self, text: str) -> None:
        if text not in self._warned:
            self._warned.add(text)
            self._say(_WARNING, text)

    def _request_list(self, message: Message, sender: Sender) -> None:
        if message.mission_type not in {dialect.MAV_MISSION_TYPE_MISSION, *_OTHER_LISTS}:
            self._ack(sender, dialect.MAV_MISSION_UNSUPPORTED, message.mission_type)
        elif message.mission_type in _OTHER_LISTS or not self._is_busy(sender):
            self._send_count(sender, message.mission_type)

    def _send_count(self, sender: Sender, mission_type: int) -> None:
        count = 0 if mission_type in _OTHER_LISTS else len(self._store)
        sender.channel.send(
            dialect.MAVLink_mission_count_message(sender.system, sender.component, count, mission_type)
        )

    def _request(self, message: Message, sender: Sender) -> None:
        if self._is_elsewhere(message, sender, dialect.MAV_MISSION_ERROR) or self._is_busy(sender):
            return
        item = self._store.read(message.seq)
        if item is None:
            self._send_count(sender, dialect.MAV_MISSION_TYPE_MISSION)
            self._ack(sender, dialect.MAV_MISSION_ERROR)
            return
        as_float = message.get_type() == "MISSION_REQUEST"
        if as_float and self._faults.knows_item_int:
            self._warn_once("got MISSION_REQUEST; use MISSION_REQUEST_INT!")
        answer = item_float if as_float else item_int
        current = message.seq == self._current_seq()
        sender.channel.send(
            answer(item, message.seq, current=current, system=sender.system, component=sender.component)
        )

    def _clear_all(self, message: Message, sender: Sender) -> None:
        if self._is_elsewhere(message, sender, dialect.MAV_MISSION_ACCEPTED):
            return
        cleared = self._upload is None and self._may_clear()
        if cleared:
            self._store.truncate(0)
        self._ack(sender, dialect.MAV_MISSION_ACCEPTED if cleared else dialect.MAV_MISSION_ERROR)
