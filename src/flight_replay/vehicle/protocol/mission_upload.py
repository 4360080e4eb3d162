"""Uploads a mission fast over slow and lossy links, and heeds every answer.

ArduPilot requests item after item (MissionItemProtocol.cpp), repeats a request after 1 s and gives up
after 8 s, of its own time. It also accepts an item that it has not requested yet if that is the next
in order, and answers any other with INVALID_SEQUENCE, which does not end the upload. So a window of
items is kept in flight, and sent again from the last one requested when nothing moves: no loss waits
for the vehicle's second, and a long delay is paid once instead of for each item.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from flight_replay.exceptions import MissionError, VehicleError
from flight_replay.mavlink import MISSION_RESULTS, Message, dialect
from flight_replay.mission.items import MissionItem
from flight_replay.vehicle.link import timesync
from flight_replay.vehicle.link.vehicle_link import Inbox, VehicleLink
from flight_replay.vehicle.protocol.mission_items import item_message

_MAX_ERRORS = 4
_MAX_COUNT = 0xFFFF
_BUSY_S = 1.0
_NO_PROGRESS_S = 12.0
_TOTAL_S, _ITEM_S = 60.0, 2.0
"""How long an upload may take in all, and more for each item."""


class MissionUploader:
    """One upload of a mission; ``items`` starts with home, item 0.

    ``before_count`` is called before each MISSION_COUNT, with which the vehicle drops the mission that it
    has; an exception that it raises ends the upload.

    Raises:
        MissionError: There are more items than MISSION_COUNT can count.
    """

    def __init__(
        self,
        link: VehicleLink,
        items: Sequence[MissionItem],
        *,
        as_int: bool,
        before_count: Callable[[], None] = lambda: None,
    ) -> None:
        if len(items) > _MAX_COUNT:
            raise MissionError(
                f"the mission has {len(items) - 1} items, too many for MAVLink; "
                "choose fewer with --max-points"
            )
        self._link, self._round_trip, self._items, self._as_int = link, link.round_trip, items, as_int
        self._before_count = before_count
        self._errors = 0
        self._refusal = ""
        self._highest = -1  # The highest item requested in any attempt: only a higher one is progress.
        self._restart()

    def _restart(self) -> None:
        """Start from the first item: nothing is on board yet."""
        self._requested = -1  # The last item requested: the vehicle has all before it.
        self._next = 0  # The next item to send.
        self._sent_s: dict[int, float] = {}
        self._resent: set[int] = set()

    def run(self, progress: Callable[[int], None]) -> None:
        """Upload all items; ``progress`` gets the number of items that the vehicle has.

        Returns when the vehicle accepted the mission, or may have: only a download shows.

        Raises:
            MissionError: The vehicle refused the mission.
            VehicleError: The vehicle stopped answering, or another ground station uploads to it.
        """
        now_s = self._link.now_s
        end_s = now_s() + _TOTAL_S + _ITEM_S * len(self._items)
        with self._link.inbox("MISSION_REQUEST", "MISSION_REQUEST_INT", "MISSION_ACK") as inbox:
            self._send_count()
            progress_s = now_s()
            while True:
                if now_s() - progress_s > _NO_PROGRESS_S or now_s() > end_s:
                    raise VehicleError(self._timeout())
                message = inbox.get(self._last_sent_s + self._round_trip.retry_s - now_s())
                if message is None:
                    self._round_trip.lost()
                    timesync.ping(self._link)
                    self._resend()
                elif message.get_type() == "MISSION_ACK":
                    if self._on_ack(message, inbox):
                        progress(len(self._items))
                        return
                elif self._on_request(message):
                    progress(message.seq)
                    progress_s = now_s()

    def _send_count(self) -> None:
        self._before_count()
        link = self._link
        link.send(dialect.MAVLink_mission_count_message(link.system, link.component, len(self._items)))
        self._last_sent_s = link.now_s()

    def _send(self, seq: int) -> None:
        self._link.send(item_message(self._link, seq, self._items[seq], as_int=self._as_int))
        self._last_sent_s = self._link.now_s()
        if seq in self._sent_s:
            self._resent.add(seq)
        self._sent_s[seq] = self._last_sent_s

    def _fill_window(self) -> None:
        self._next = max(self._next, self._requested)
        while self._next < min(self._requested + self._round_trip.window, len(self._items)):
            self._send(self._next)
            self._next += 1

    def _resend(self) -> None:
        """Send again from the last item requested, or the count if none was.

        One more item than before is sent: if the vehicle has them all and only its requests were
        lost, it waits for that one.
        """
        if self._requested < 0:
            self._send_count()
            return
        for seq in range(self._requested, min(self._next + 1, len(self._items))):
            self._send(seq)
            self._next = max(self._next, seq + 1)

    def _on_request(self, message: Message) -> bool:
        """Whether a request shows that the vehicle has more items than ever before."""
        seq = message.seq
        # A vehicle that requests MISSION_ITEM_INT knows it, even if its capabilities were not received.
        self._as_int = self._as_int or message.get_type() == "MISSION_REQUEST_INT"
        if seq >= len(self._items):
            return False
        self._measure(seq)
        if seq > self._requested:
            self._requested = seq
            self._fill_window()
        elif self._is_overdue(seq):
            # Requested again after the item should have arrived, or a duplicated count restarted all.
            self._requested = seq
            self._resend()
        is_progress = self._requested > self._highest
        self._highest = max(self._highest, self._requested)
        return is_progress

    def _measure(self, seq: int) -> None:
        """Measure the round trip by a request that follows from an item, sent once (Karn's rule)."""
        before = seq - 1
        if before in self._sent_s and before not in self._resent and seq > self._requested:
            self._round_trip.measured(self._link.now_s() - self._sent_s[before])

    def _is_overdue(self, seq: int) -> bool:
        return self._link.now_s() - self._sent_s.get(seq, 0.0) > self._round_trip.median_s

    @property
    def _all_sent(self) -> bool:
        return self._next >= len(self._items)

    def _on_ack(self, message: Message, inbox: Inbox) -> bool:
        """Whether a MISSION_ACK ends the upload well, as far as can be seen.

        Raises:
            MissionError: It refuses the mission.
        """
        result = message.type
        if getattr(message, "mission_type", 0) != dialect.MAV_MISSION_TYPE_MISSION:
            return False
        if result == dialect.MAV_MISSION_ACCEPTED:
            return self._all_sent  # Otherwise it is a late answer to an earlier upload.
        self._refusal = MISSION_RESULTS.get(result, str(result))
        if result == dialect.MAV_MISSION_INVALID_SEQUENCE:
            if self._is_overdue(self._requested):
                self._resend()
            return False
        if result == dialect.MAV_MISSION_DENIED:
            inbox.get(_BUSY_S)
            self._send_count()
            return False
        if result == dialect.MAV_MISSION_OPERATION_CANCELLED:
            self._restart()
            self._send_count()
            return False
        return self._on_error(result)

    def _on_error(self, result: int) -> bool:
        """A result that ends a transfer: a refusal, or the vehicle no longer knows of an upload.

        Raises:
            MissionError: It refuses the mission.
        """
        if result == dialect.MAV_MISSION_ERROR and self._requested < 0:
            return False  # Items of a cancelled transfer were still in flight.
        self._errors += 1
        if result == dialect.MAV_MISSION_ERROR and self._all_sent:
            return True  # An item sent after the last one was accepted: the acceptance was lost.
        if result == dialect.MAV_MISSION_ERROR and self._errors < _MAX_ERRORS:
            self._restart()
            self._send_count()
            return False
        raise MissionError(self._refused(result))

    def _refused(self, result: int) -> str:
        if result == dialect.MAV_MISSION_NO_SPACE:
            return (
                f"the vehicle has no space for {len(self._items) - 1} mission items; "
                "choose fewer with --max-points"
            )
        where = f"mission item {self._requested}" if self._requested > 0 else "the mission"
        return (
            f"the vehicle refused {where}: {self._refusal}; "
            "the mission on board may be incomplete: check the item, then start again"
        )

    def _timeout(self) -> str:
        if self._refusal == MISSION_RESULTS[dialect.MAV_MISSION_DENIED]:
            return "another ground station uploads a mission; wait until it is done, then start again"
        why = f": last answer {self._refusal}" if self._refusal else ": no answer"
        return (
            f"upload stopped at mission item {max(self._requested, 0)}{why}; check the link, then start again"
        )
