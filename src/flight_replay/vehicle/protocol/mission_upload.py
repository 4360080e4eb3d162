"""Sends a mission so that slow and lossy links carry it soon, and every answer is heeded.

ArduPilot asks for item after item (MissionItemProtocol.cpp), again after 1 s, and gives up after
8 s, of its own time. It also takes an item that it has not asked for yet, if it is the next in
order, and answers any other with INVALID_SEQUENCE, which ends nothing. So a window of items is kept
under way, and sent again from the last one asked for when nothing moves: no loss waits for the
vehicle's second, and a long delay is paid once instead of for each item.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from flight_replay.errors import MissionError, VehicleError
from flight_replay.mavlink import MISSION_RESULTS, Message, dialect
from flight_replay.mission.items import MissionItem
from flight_replay.vehicle.link import timesync
from flight_replay.vehicle.link.port import Inbox, Port
from flight_replay.vehicle.protocol.mission_items import item_message

_ERRORS_ENOUGH = 4
_BUSY_S = 1.0


@dataclass(frozen=True, slots=True)
class UploadLimits:
    """Seconds here: without progress, and altogether as ``total_s`` and so much for each item."""

    quiet_s: float = 12.0
    total_s: float = 60.0
    item_s: float = 2.0


class Upload:
    """One mission on its way; ``items`` begins with home's slot, number 0."""

    def __init__(
        self,
        port: Port,
        items: Sequence[MissionItem],
        *,
        as_int: bool,
        limits: UploadLimits | None = None,
    ) -> None:
        self._port, self._trip, self._items, self._as_int = port, port.trip, items, as_int
        self._limits = limits or UploadLimits()
        self._errors = 0
        self._refusal = ""
        self._most = -1  # The farthest that any attempt came: only that counts as progress.
        self._restart()

    def _restart(self) -> None:
        """Nothing is on board yet."""
        self._asked = -1  # The item asked for last: the vehicle has all before it.
        self._next = 0  # The next item to be sent.
        self._sent_s: dict[int, float] = {}
        self._again: set[int] = set()

    def run(self, progress: Callable[[int], None]) -> None:
        """Send everything; ``progress`` hears how many items the vehicle took.

        Returns when the vehicle accepted the mission, or may have: only reading it back shows.

        Raises:
            MissionError: The vehicle refused the mission.
            VehicleError: The vehicle stopped answering, or another station is sending it a mission.
        """
        now_s = self._port.now_s
        end_s = now_s() + self._limits.total_s + self._limits.item_s * len(self._items)
        with self._port.inbox(
            "MISSION_REQUEST", "MISSION_REQUEST_INT", "MISSION_ACK", timesync.KIND
        ) as inbox:
            self._send_count()
            moved_s = now_s()
            while True:
                if now_s() - moved_s > self._limits.quiet_s or now_s() > end_s:
                    raise VehicleError(self._stalled())
                message = inbox.get(self._sent_last_s + self._trip.again_s - now_s())
                if message is None:
                    self._trip.lost()
                    timesync.ping(self._port)
                    self._send_again()
                elif timesync.learn(self._port, message):
                    continue
                elif message.get_type() == "MISSION_ACK":
                    if self._take_ack(message, inbox):
                        progress(len(self._items))
                        return
                elif self._take_request(message):
                    progress(message.seq)
                    moved_s = now_s()

    def _send_count(self) -> None:
        port = self._port
        port.send(dialect.MAVLink_mission_count_message(port.system, port.component, len(self._items)))
        self._sent_last_s = port.now_s()

    def _send(self, seq: int) -> None:
        self._port.send(item_message(self._port, seq, self._items[seq], as_int=self._as_int))
        self._sent_last_s = self._port.now_s()
        if seq in self._sent_s:
            self._again.add(seq)
        self._sent_s[seq] = self._sent_last_s

    def _fill_window(self) -> None:
        self._next = max(self._next, self._asked)
        while self._next < min(self._asked + self._trip.window, len(self._items)):
            self._send(self._next)
            self._next += 1

    def _send_again(self) -> None:
        """Nothing has moved: once more from the item asked for last, or the count.

        One more item goes along than was sent before: if the vehicle took them all and only its
        requests were lost, that is the one it waits for.
        """
        if self._asked < 0:
            self._send_count()
            return
        for seq in range(self._asked, min(self._next + 1, len(self._items))):
            self._send(seq)
            self._next = max(self._next, seq + 1)

    def _take_request(self, message: Message) -> bool:
        """Whether a request shows that the vehicle took more than ever before."""
        seq = message.seq
        # Who asks for integers takes them, though its word on what it can do was not heard.
        self._as_int = self._as_int or message.get_type() == "MISSION_REQUEST_INT"
        if seq >= len(self._items):
            return False
        self._measure(seq)
        if seq > self._asked:
            self._asked = seq
            self._fill_window()
        elif self._is_late(seq):
            # Asked again after what was sent should have arrived, or a doubled count began anew.
            self._asked = seq
            self._send_again()
        news = self._asked > self._most
        self._most = max(self._most, self._asked)
        return news

    def _measure(self, seq: int) -> None:
        """Learn the round-trip time from a request that an item, sent once, brought about."""
        before = seq - 1
        if before in self._sent_s and before not in self._again and seq > self._asked:
            self._trip.took(self._port.now_s() - self._sent_s[before])

    def _is_late(self, seq: int) -> bool:
        return self._port.now_s() - self._sent_s.get(seq, 0.0) > self._trip.typical_s

    @property
    def _all_sent(self) -> bool:
        return self._next >= len(self._items)

    def _take_ack(self, message: Message, inbox: Inbox) -> bool:
        """Whether an answer ends the upload well, as far as can be seen.

        Raises:
            MissionError: It ends the upload.
        """
        result = message.type
        if getattr(message, "mission_type", 0) != dialect.MAV_MISSION_TYPE_MISSION:
            return False
        if result == dialect.MAV_MISSION_ACCEPTED:
            return self._all_sent  # Else it is the late answer to something older.
        self._refusal = MISSION_RESULTS.get(result, str(result))
        if result == dialect.MAV_MISSION_INVALID_SEQUENCE:
            if self._is_late(self._asked):
                self._send_again()
            return False
        if result == dialect.MAV_MISSION_DENIED:
            inbox.get(_BUSY_S)
            self._send_count()
            return False
        if result == dialect.MAV_MISSION_OPERATION_CANCELLED:
            self._restart()
            self._send_count()
            return False
        return self._take_error(result)

    def _take_error(self, result: int) -> bool:
        """An answer that ends a transfer: a refusal, or an upload that the vehicle no longer knows of."""
        if result == dialect.MAV_MISSION_ERROR and self._asked < 0:
            return False  # Items of a cancelled transfer that were still on their way.
        self._errors += 1
        if result == dialect.MAV_MISSION_ERROR and self._all_sent:
            return True  # What comes after the last item is no longer wanted: its acceptance was lost.
        if result == dialect.MAV_MISSION_ERROR and self._errors < _ERRORS_ENOUGH:
            self._restart()
            self._send_count()
            return False
        raise MissionError(self._refused(result))

    def _refused(self, result: int) -> str:
        if result == dialect.MAV_MISSION_NO_SPACE:
            return (
                f"the vehicle has no room for {len(self._items) - 1} mission items; "
                "choose fewer with --max-points"
            )
        where = f"mission item {self._asked}" if self._asked > 0 else "the mission"
        return f"the vehicle refused {where}: {self._refusal}; what is on board now may be cut short"

    def _stalled(self) -> str:
        if self._refusal == MISSION_RESULTS[dialect.MAV_MISSION_DENIED]:
            return "another station is sending the vehicle a mission; wait until it is done, then start again"
        why = f" (its last answer: {self._refusal})" if self._refusal else ""
        return (
            f"the upload stopped at mission item {max(self._asked, 0)}{why}; check the link, then start again"
        )
